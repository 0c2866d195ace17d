// SPDX-License-Identifier: Apache-2.0
// What the network learns from: inputs, and targets made of simulated vertices (NDG section 4.5).
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/neural/half_rows.h"
#include "ndg/neural/model.h"

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace ndg {

/// The samples of one split. Only simulations that converged are used (statistic "converged" = 1; sets without that
/// statistic are used whole). Keeps references to all of its sources and to the model's output space, which must
/// outlive it; sets that were only opened are read sample by sample.
class TrainingSet {
public:
    /// Inputs and targets in the spaces of `model`. Targets are made when they are first asked for. At most
    /// `cache_gigabytes` are taken to keep them, in float16 about the neutral prediction, and the rest operators of
    /// bodies; where all targets fit operators go when the last target of their body is kept, otherwise operators come
    /// first, and what is not kept is made anew. With `max_samples` only so many are used, the
    /// first of the files; 0: all. Throws InputError when a body, pose or vertex count does not fit, when
    /// a pair occurs twice, or when no sample of the split is left.
    TrainingSet(const NeuralModel& model, const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                const std::vector<DeformationSet>& deformations, const std::string& split, double cache_gigabytes = 8.0,
                int max_samples = 0);

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
    /// OutputSpace::target of a sample, width() numbers, rounded as HalfRows does whether it is kept or not. May be
    /// called by any thread.
    void target(int sample_idx, float* target) const;
    /// SHA-256 of pairs, features and the simulations' figures (energy, residual and the like) of all samples and of
    /// the vertices of a few, so that not all have to be read: two sets with the same digest train the same network.
    std::string digest() const;

private:
    struct Sample {
        SamplePair pair;
        const DeformationSet* set;
        int place;  ///< in the set
    };
    void choose_samples(const std::vector<DeformationSet>& deformations, const std::string& split, int max_samples);
    void compute_features(const InputSpace& input_space);
    /// Rest operators of a body while they are needed.
    struct KeptRest {
        std::mutex mutex;
        std::shared_ptr<const RestOperators> operators;
        std::atomic<int> needed = 0;  ///< by samples whose targets are not kept
    };
    void plan_memory(double max_bytes);
    std::shared_ptr<const RestOperators> rest_operators(int body_idx) const;
    void compute_target(int sample_idx, const RestOperators& rest, float* target) const;

    const OutputSpace* output_space_;
    BodyPoser poser_;
    const BodySet* bodies_;
    const PoseSet* poses_;
    std::vector<Sample> samples_;
    int num_unconverged_ = 0;
    RowMatrixF features_;
    std::unique_ptr<HalfRows> kept_targets_;
    std::map<int, std::unique_ptr<KeptRest>> kept_rest_;  ///< by body, of those that may be kept
};

}  // namespace ndg
