// SPDX-License-Identifier: Apache-2.0
// Which body in which pose (splits and pairs), and deformed volumes (FEM samples and predictions alike).
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

class H5Reader;
struct VirtualSource;

/// One sample: a body of the body file in a pose of the pose file.
struct SamplePair {
    int body_idx = 0;
    int pose_idx = 0;
};

/// Names of the splits, in storage order.
inline const std::vector<std::string> split_names = {"train", "validation", "test"};

struct Splits {
    std::map<std::string, std::vector<int>> bodies;        ///< split -> body indices
    std::map<std::string, std::vector<int>> poses;         ///< split -> pose indices
    std::map<std::string, std::vector<SamplePair>> pairs;  ///< split -> samples, without repetition
};
void write_splits(const std::string& path, const Splits& splits, const Provenance& provenance);
/// Checks ranges (num_bodies, num_poses; -1: unchecked), that splits are disjoint and that pairs keep to their split.
Splits read_splits(const std::string& path, int num_bodies = -1, int num_poses = -1);

/// A sample that has no deformation, and why.
struct FailedSample {
    SamplePair pair;
    std::string split, reason;
};

/// Deformed volume vertices of samples, float32 as stored. The same file format serves FEM samples and predictions.
struct DeformationSet {
    std::string method;  ///< "FEM", "NDG", "Gradient Skinning", "LBS"
    std::vector<SamplePair> pairs;
    std::vector<std::string> pair_splits;  ///< split name of each sample
    int num_volume_vertices = 0;
    std::vector<std::vector<float>> vertices;  ///< per sample N_v * 3, row-major; none in a set that was only opened
    /// Per-sample figures, e.g. energy_joule, residual_newton, residual_relative, iterations, converged,
    /// inverted_prisms, seconds: name -> one value a sample.
    std::map<std::string, std::vector<double>> statistics;
    std::vector<std::string> stop_reasons;  ///< why the solver stopped, one a sample; empty where there is no solver
    std::vector<FailedSample> failures;
    std::map<std::string, std::string> attributes;  ///< text of the file's root beyond what every file has
    std::shared_ptr<const H5Reader> file;           ///< of an opened set: where the vertices are read when asked for

    int size() const { return static_cast<int>(pairs.size()); }
    /// N_v * 3, row-major. Of an opened set: throws InputError where the file is damaged; may be called by any thread.
    std::vector<float> coordinates(int sample_idx) const;
    Points points(int sample_idx) const;
    void add(const SamplePair& pair, const std::string& split, const Points& vertices);
};
void write_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance);
/// The same with the coordinates asked for one sample at a time: the set itself needs no vertices.
void write_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance,
                        const std::function<std::vector<float>(int sample_idx)>& coordinates);
/// The same with the coordinates left in the files they stand in (a virtual dataset over `sources`).
void link_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance,
                       const std::vector<VirtualSource>& sources);
/// Everything in memory. num_volume_vertices -1: unchecked.
DeformationSet read_deformations(const std::string& path, int num_volume_vertices = -1);
/// Everything but the vertices, which are read when asked for: a set of any size. Throws InputError where a file that
/// the samples lie in is missing.
DeformationSet open_deformations(const std::string& path, int num_volume_vertices = -1);

}  // namespace ndg
