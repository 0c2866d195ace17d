// SPDX-License-Identifier: Apache-2.0
// What the network learns from: inputs and simulated residuals (NDG section 4.5).
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"
#include "ndg/neural/options.h"

#include <string>
#include <vector>

namespace ndg {

/// The samples of one split. Only simulations that converged are used (statistic "converged" = 1; sets without that
/// statistic are used whole). Keeps references to all of its sources, which must outlive it; sets that were only opened
/// are read sample by sample.
class TrainingSet {
public:
    /// Targets are computed from the stored vertices once and kept as long as they fit in `cache_gigabytes`, otherwise
    /// anew whenever they are asked for. Throws InputError when a body, pose or vertex count does not fit, when a pair
    /// occurs twice, or when no sample of the split is left.
    TrainingSet(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                const std::vector<DeformationSet>& deformations, const std::string& split,
                const ShapeSpace& shape_space, const NetworkOptions& options, double cache_gigabytes = 8.0);

    int size() const { return static_cast<int>(samples_.size()); }
    int num_prisms() const { return template_->num_prisms(); }
    /// Samples of the split left out because their simulation had not converged.
    int num_unconverged() const { return num_unconverged_; }
    const SamplePair& pair(int sample_idx) const { return samples_[static_cast<std::size_t>(sample_idx)].pair; }

    /// size() x (9 J + d), see network_features.
    const RowMatrixF& features() const { return features_; }
    /// R_p^T F_p with F = G X (without `rotation`: the root's rotation for R_p), N_p * 9, F row-major.
    void residuals(int sample_idx, float* target) const;
    /// SHA-256 of the pairs, features and vertices: two sets with the same digest train the same network.
    std::string digest() const;

private:
    struct Sample {
        SamplePair pair;
        const DeformationSet* set;
        int place;  ///< in the set
    };
    void compute(int sample_idx, float* target) const;

    const Template* template_;
    const BodySet* bodies_;
    const PoseSet* poses_;
    bool rotation_;
    SkinningWeights prism_weights_;
    std::vector<Sample> samples_;
    int num_unconverged_ = 0;
    RowMatrixF features_;
    std::vector<std::vector<float>> cache_;
};

}  // namespace ndg
