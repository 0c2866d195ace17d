// SPDX-License-Identifier: Apache-2.0
// What the network learns from: inputs, and targets made of simulated vertices (NDG section 4.5).
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/neural/model.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

/// The samples of one split. Only simulations that converged are used (statistic "converged" = 1; sets without that
/// statistic are used whole). Keeps references to all of its sources and to the model's output space, which must
/// outlive it; sets that were only opened are read sample by sample.
class TrainingSet {
public:
    /// Inputs and targets in the spaces of `model`. Targets are computed once and kept where they fit in
    /// `cache_gigabytes`, otherwise anew whenever they are asked for, with the bodies' rest operators kept where
    /// those fit. Throws InputError when a body, pose or vertex count does not fit, when a pair occurs twice, or
    /// when no sample of the split is left.
    TrainingSet(const NeuralModel& model, const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                const std::vector<DeformationSet>& deformations, const std::string& split,
                double cache_gigabytes = 8.0);

    int size() const { return static_cast<int>(samples_.size()); }
    /// Numbers of a target.
    int width() const { return output_space_->width(); }
    /// Samples of the split left out because their simulation had not converged.
    int num_unconverged() const { return num_unconverged_; }
    const SamplePair& pair(int sample_idx) const { return samples_[sample_idx].pair; }
    const Body& body(int sample_idx) const { return bodies_->bodies[pair(sample_idx).body_idx]; }
    const Pose& pose(int sample_idx) const { return poses_->poses[pair(sample_idx).pose_idx]; }
    const Template& body_template() const { return poser_.body_template(); }

    /// size() x InputSpace::width().
    const RowMatrixF& features() const { return features_; }
    /// OutputSpace::target of a sample, width() numbers. May be called by any thread.
    void target(int sample_idx, float* target) const;
    /// SHA-256 of the pairs, features and vertices: two sets with the same digest train the same network.
    std::string digest() const;

private:
    struct Sample {
        SamplePair pair;
        const DeformationSet* set;
        int place;  ///< in the set
    };
    void choose_samples(const std::vector<DeformationSet>& deformations, const std::string& split);
    void compute_features(const InputSpace& input_space);
    void keep_what_fits(double cache_gigabytes);
    RestOperators rest_operators(int body_idx) const;
    void compute_target(int sample_idx, const RestOperators& rest, float* target) const;

    const OutputSpace* output_space_;
    BodyPoser poser_;
    const BodySet* bodies_;
    const PoseSet* poses_;
    std::vector<Sample> samples_;
    int num_unconverged_ = 0;
    RowMatrixF features_;
    RowMatrixF kept_targets_;                 ///< one row a sample, or none
    std::map<int, RestOperators> kept_rest_;  ///< of every body of a sample, or of none
};

}  // namespace ndg
