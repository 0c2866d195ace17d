// SPDX-License-Identifier: Apache-2.0
// Table 1 of NDG 2026: methods against the FEM reference over the pairs of one split.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/evaluate/metrics.h"

#include <string>
#include <utility>
#include <vector>

namespace ndg {

/// One row: a method, and its figures for every pair of the split and on average.
struct MethodMetrics {
    std::string method;
    std::vector<SamplePair> pairs;
    std::vector<SampleMetrics> samples;
    SampleMetrics mean;
};

/// A deformation file in memory and the path it was read from (for messages).
struct NamedDeformations {
    std::string path;
    DeformationSet set;
};

/// The pairs that every method is compared with FEM on.
struct ComparedPairs {
    std::vector<SamplePair> pairs;  ///< in the order given
    int unconverged = 0;            ///< left out: FEM did not converge (statistic "converged" is 0)
    int failed = 0;                 ///< left out: FEM gave no deformation (listed among the file's failures)
};
/// Throws InputError for a pair that the reference neither holds nor lists as failed, and where no pair is left.
ComparedPairs compared_pairs(const std::vector<SamplePair>& pairs, const std::string& split,
                             const NamedDeformations& reference);

/// One row a file: the reference, then the predictions in their order. Samples are matched by (body, pose). Throws
/// InputError for an empty split, a missing or doubled pair, a sample stored under another split, a body index without
/// body, a method that comes twice, and files that are damaged.
std::vector<MethodMetrics> evaluate_methods(const Template& body_template, const BodySet& bodies,
                                            const std::vector<SamplePair>& pairs, const std::string& split,
                                            const NamedDeformations& reference,
                                            const std::vector<NamedDeformations>& predictions);

/// Sizes of the data the table was made from, and what FEM achieved.
struct TableCounts {
    int bodies = 0, poses = 0, samples = 0;
    int prisms = 0, volume_vertices = 0, free_vertices = 0;
    std::vector<std::pair<std::string, int>> split_samples;  ///< split name -> reference samples stored under it
    int evaluated_samples = 0, evaluated_bodies = 0, evaluated_poses = 0;
    int unconverged_samples = 0, failed_samples = 0;  ///< of the evaluated split, left out (ComparedPairs)
    double fem_converged_share = 0;                   ///< of all samples of the reference file
    std::string fem_convergence_criterion;            ///< as the reference file states it
    int invalid_rest_prisms = 0;                      ///< over all bodies, by check_prisms
};
/// Throws InputError when the reference has no statistic "converged".
TableCounts count_data(const Template& body_template, const BodySet& bodies, int num_poses,
                       const ComparedPairs& compared, const NamedDeformations& reference,
                       const std::string& convergence_criterion);

/// What a deformation file says of its convergence criterion: its root attribute "convergence_criterion", or else the
/// tolerances of simulate-fem (NewtonOptions) in the configuration stored with it, or else that configuration as it is.
/// Throws InputError when it is not an HDF5 file.
std::string convergence_criterion(const std::string& deformation_path);

}  // namespace ndg
