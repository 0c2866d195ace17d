// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/training_set.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/geometry/prism.h"
#include "ndg/neural/input_space.h"

#include <exception>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace ndg {
namespace {

std::string_view bytes_of(const float* data, std::size_t count)
{
    return {reinterpret_cast<const char*>(data), count * sizeof(float)};
}

}  // namespace

TrainingSet::TrainingSet(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                         const std::vector<DeformationSet>& deformations, const std::string& split,
                         const ShapeSpace& shape_space, const NetworkOptions& options, double cache_gigabytes)
    : template_(&body_template),
      bodies_(&bodies),
      poses_(&poses),
      rotation_(options.rotation),
      prism_weights_(body_template.prism_weights())
{
    const Eigen::Index coordinates = 3 * body_template.num_volume_vertices();
    require_input(shape_space.mean.size() == coordinates,
                  "the shape space has {} coordinates where the template's volume has {}", shape_space.mean.size(),
                  coordinates);
    std::set<std::pair<int, int>> seen;
    for (const DeformationSet& set : deformations) {
        require_input(set.num_volume_vertices == body_template.num_volume_vertices(),
                      "the samples have {} volume vertices where the template has {}", set.num_volume_vertices,
                      body_template.num_volume_vertices());
        const auto converged = set.statistics.find("converged");
        for (std::size_t i = 0; i < set.pairs.size(); ++i) {
            if (set.pair_splits[i] != split) continue;
            const SamplePair& pair = set.pairs[i];
            require_input(pair.body_idx >= 0 && pair.body_idx < static_cast<int>(bodies.bodies.size()),
                          "sample {} names body {} of {}", i, pair.body_idx, bodies.bodies.size());
            require_input(pair.pose_idx >= 0 && pair.pose_idx < poses.size(), "sample {} names pose {} of {}", i,
                          pair.pose_idx, poses.size());
            require_input(seen.emplace(pair.body_idx, pair.pose_idx).second,
                          "the samples contain body {} in pose {} twice", pair.body_idx, pair.pose_idx);
            if (converged != set.statistics.end() && converged->second[i] != 1.0) {
                ++num_unconverged_;
                continue;
            }
            samples_.push_back({pair, &set, static_cast<int>(i)});
        }
    }
    require_input(!samples_.empty(), "the samples hold no converged simulation of the split \"{}\" ({} unconverged)",
                  split, num_unconverged_);

    const std::vector<int> visible = visible_joints(body_template);
    std::map<int, Eigen::VectorXd> codes;
    for (int i = 0; i < size(); ++i) {
        const auto body_idx = pair(i).body_idx;
        auto code = codes.find(body_idx);
        if (code == codes.end()) {
            const Body& body = bodies.bodies[static_cast<std::size_t>(body_idx)];
            code = codes.emplace(body_idx, shape_space.encode(body.volume_vertices)).first;
        }
        const PoseInput input{code->second, poses.poses[static_cast<std::size_t>(pair(i).pose_idx)]};
        const Eigen::RowVectorXf row = network_features(input, visible, shape_space, options.shape);
        if (i == 0) features_.resize(size(), row.size());
        features_.row(i) = row;
    }

    const double gigabytes = 1e-9 * sizeof(float) * 9.0 * num_prisms() * size();
    if (gigabytes > cache_gigabytes) return;
    std::vector<std::vector<float>> cache(samples_.size());
    std::exception_ptr failure;
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < size(); ++i) {
        try {
            std::vector<float>& target = cache[static_cast<std::size_t>(i)];
            target.resize(static_cast<std::size_t>(num_prisms()) * 9);
            compute(i, target.data());
        } catch (...) {
#pragma omp critical
            failure = std::current_exception();
        }
    }
    if (failure) std::rethrow_exception(failure);
    cache_ = std::move(cache);
}

void TrainingSet::compute(int sample_idx, float* target) const
{
    const Sample& sample = samples_[static_cast<std::size_t>(sample_idx)];
    const Points& rest = bodies_->bodies[static_cast<std::size_t>(sample.pair.body_idx)].volume_vertices;
    const Pose& pose = poses_->poses[static_cast<std::size_t>(sample.pair.pose_idx)];
    const std::vector<Eigen::Matrix3d> rotations =
        reference_rotations(template_->skeleton, prism_weights_, pose, rotation_);
    const std::vector<float> stored = sample.set->coordinates(sample.place);
    const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>> vertices(
        stored.data(), template_->num_volume_vertices(), 3);
    for (Eigen::Index p = 0; p < template_->prisms.rows(); ++p) {
        PrismVertices posed;
        for (int k = 0; k < 6; ++k) posed.row(k) = vertices.row(template_->prisms(p, k)).cast<double>();
        const PrismGradient gradient = prism_gradient_operator(gather_prism(rest, template_->prisms, p));
        const Eigen::Matrix3d transposed = gradient * posed;  // F^T
        const Eigen::Matrix3d residual = rotations[static_cast<std::size_t>(p)].transpose() * transposed.transpose();
        for (int row = 0; row < 3; ++row)
            for (int col = 0; col < 3; ++col) *target++ = static_cast<float>(residual(row, col));
    }
}

void TrainingSet::residuals(int sample_idx, float* target) const
{
    if (cache_.empty()) {
        compute(sample_idx, target);
        return;
    }
    const std::vector<float>& cached = cache_[static_cast<std::size_t>(sample_idx)];
    std::copy(cached.begin(), cached.end(), target);
}

std::string TrainingSet::digest() const
{
    std::string digests = sha256(bytes_of(features_.data(), static_cast<std::size_t>(features_.size())));
    for (const Sample& sample : samples_) {
        digests += fmt::format(" {} {} ", sample.pair.body_idx, sample.pair.pose_idx);
        const std::vector<float> stored = sample.set->coordinates(sample.place);
        digests += sha256(bytes_of(stored.data(), stored.size()));
    }
    return sha256(digests);
}

}  // namespace ndg
