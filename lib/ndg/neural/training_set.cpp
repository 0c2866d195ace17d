// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/training_set.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"

#include <algorithm>
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

TrainingSet::TrainingSet(const NeuralModel& model, const Template& body_template, const BodySet& bodies,
                         const PoseSet& poses, const std::vector<DeformationSet>& deformations,
                         const std::string& split, double cache_gigabytes, int max_samples)
    : output_space_(&model.output_space()),
      poser_(body_template, model.options().posing),
      bodies_(&bodies),
      poses_(&poses)
{
    choose_samples(deformations, split, max_samples);
    compute_features(model.input_space());
    plan_memory(1e9 * cache_gigabytes);
}

void TrainingSet::choose_samples(const std::vector<DeformationSet>& deformations, const std::string& split,
                                 int max_samples)
{
    std::set<SamplePair> seen;
    const int num_vertices = poser_.body_template().num_volume_vertices();
    for (const DeformationSet& set : deformations) {
        require_input(set.num_volume_vertices == num_vertices,
                      "the samples have {} volume vertices where the template has {}", set.num_volume_vertices,
                      num_vertices);
        require_input(set.posing.bone_wrap == poser_.options().bone_wrap,
                      "the samples are of bone-wrap {}, the model is made for {}", to_name(set.posing.bone_wrap),
                      to_name(poser_.options().bone_wrap));
        const auto converged = set.statistics.find("converged");
        for (std::size_t i = 0; i < set.pairs.size(); ++i) {
            if (set.pair_splits[i] != split) continue;
            const SamplePair& pair = set.pairs[i];
            require_pair(pair, bodies_->bodies.size(), poses_->poses.size());
            require_input(seen.insert(pair).second, "the samples contain {} twice", describe(pair));
            if (converged != set.statistics.end() && converged->second[i] != 1.0) {
                ++num_unconverged_;
                continue;
            }
            samples_.push_back({pair, &set, static_cast<int>(i)});
        }
    }
    require_input(!samples_.empty(), "the samples hold no converged simulation of the split \"{}\" ({} unconverged)",
                  split, num_unconverged_);
    if (max_samples == 0) return;
    require_input(max_samples > 0 && max_samples <= size(),
                  "{} samples of the split \"{}\" were asked for, there are {}", max_samples, split, size());
    samples_.resize(max_samples);
}

void TrainingSet::compute_features(const InputSpace& input_space)
{
    features_.resize(size(), input_space.width());
    std::map<int, Eigen::VectorXd> codes;
    for (int i = 0; i < size(); ++i) {
        const auto [code, is_new] = codes.try_emplace(pair(i).body_idx);
        if (is_new) code->second = input_space.encode(bodies_->bodies[pair(i).body_idx]);
        features_.row(i) = input_space.features({code->second, poses_->poses[pair(i).pose_idx]});
    }
}

void TrainingSet::plan_memory(double max_bytes)
{
    std::map<int, int> samples_of_body;
    for (int i = 0; i < size(); ++i) ++samples_of_body[pair(i).body_idx];
    const double bytes_of_body =
        static_cast<double>(sizeof(PrismGradient) + sizeof(double)) * poser_.body_template().num_prisms();
    const double bytes_of_targets = HalfRows::bytes_of(size(), width());
    double room_for_rest = bytes_of_targets <= max_bytes ? max_bytes - bytes_of_targets : max_bytes;
    double room_for_targets = max_bytes;
    for (const auto& [body_idx, num_samples] : samples_of_body) {
        if (room_for_rest < bytes_of_body) break;
        room_for_rest -= bytes_of_body;
        room_for_targets -= bytes_of_body;
        kept_rest_[body_idx] = std::make_unique<KeptRest>();
        kept_rest_[body_idx]->needed = num_samples;
    }
    kept_targets_ = std::make_unique<HalfRows>(neutral_prediction(*output_space_), size(), room_for_targets);
}

std::shared_ptr<const RestOperators> TrainingSet::rest_operators(int body_idx) const
{
    const auto make = [&] {
        return std::make_shared<const RestOperators>(poser_.body_template().prisms,
                                                     bodies_->bodies[body_idx].volume_vertices);
    };
    const auto found = kept_rest_.find(body_idx);
    if (found == kept_rest_.end()) return make();
    const std::lock_guard<std::mutex> lock(found->second->mutex);
    std::shared_ptr<const RestOperators>& operators = found->second->operators;
    if (!operators) operators = make();
    return operators;
}

void TrainingSet::compute_target(int sample_idx, const RestOperators& rest, float* target) const
{
    const Sample& sample = samples_[sample_idx];
    const std::vector<float> stored = sample.set->coordinates(sample.place);
    const Eigen::Map<const PointsF> vertices(stored.data(), rest.num_vertices(), 3);
    const PosedBody posed =
        poser_.pose(bodies_->bodies[sample.pair.body_idx], poses_->poses[sample.pair.pose_idx], sample.pair);
    output_space_->target(posed, rest, vertices, target);
}

void TrainingSet::target(int sample_idx, float* target) const
{
    if (kept_targets_->read(sample_idx, target)) return;
    const int body_idx = pair(sample_idx).body_idx;
    compute_target(sample_idx, *rest_operators(body_idx), target);
    if (!kept_targets_->keep(sample_idx, target)) return;
    const auto found = kept_rest_.find(body_idx);
    if (found == kept_rest_.end() || --found->second->needed > 0) return;
    const std::lock_guard<std::mutex> lock(found->second->mutex);
    found->second->operators.reset();
}

std::string TrainingSet::digest() const
{
    constexpr int num_read = 16;
    std::string digests = sha256(bytes_of(features_.data(), static_cast<std::size_t>(features_.size())));
    for (int i = 0; i < size(); ++i) {
        const Sample& sample = samples_[i];
        digests += fmt::format("\n{} {}", sample.pair.body_idx, sample.pair.pose_idx);
        for (const auto& [name, values] : sample.set->statistics)
            if (name != "seconds") digests += fmt::format(" {} {}", name, values[sample.place]);
        if (i % std::max(1, size() / num_read) != 0) continue;
        const std::vector<float> stored = sample.set->coordinates(sample.place);
        digests += " " + sha256(bytes_of(stored.data(), stored.size()));
    }
    return sha256(digests);
}

}  // namespace ndg
