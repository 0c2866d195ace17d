// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/body_rig.h"

#include "ndg/core/error.h"
#include "ndg/display/sample_frames.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

namespace ndg {
namespace {

constexpr double mm_per_m = 1e3;

/// The `count` largest weights of each row in falling order, normalised; the other slots unused.
SkinningWeights strongest_weights(const SkinningWeights& weights, int count)
{
    SkinningWeights result = weights;
    result.joints.setZero();
    result.weights.setZero();
    std::array<int, max_influences> slots{};
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
        std::iota(slots.begin(), slots.end(), 0);
        std::stable_sort(slots.begin(), slots.end(),
                         [&](int a, int b) { return weights.weights(i, a) > weights.weights(i, b); });
        for (int k = 0; k < count && weights.weights(i, slots[k]) > 0.0; ++k) {
            result.joints(i, k) = weights.joints(i, slots[k]);
            result.weights(i, k) = weights.weights(i, slots[k]);
        }
        result.weights.row(i) /= result.weights.row(i).sum();
    }
    return result;
}

FrameError over_all(const std::vector<FrameError>& errors)
{
    FrameError all;
    for (const FrameError& error : errors) {
        all.mean += error.mean / double(errors.size());
        all.max = std::max(all.max, error.max);
    }
    return all;
}

nlohmann::json to_json(const std::vector<FrameError>& errors)
{
    const FrameError all = over_all(errors);
    nlohmann::json json = {{"mean_mm", mm_per_m * all.mean}, {"max_mm", mm_per_m * all.max}};
    for (const FrameError& error : errors) {
        json["frame_mean_mm"].push_back(mm_per_m * error.mean);
        json["frame_max_mm"].push_back(mm_per_m * error.max);
    }
    return json;
}

std::string table_row(const std::string& name, const FrameError& skinning, const FrameError& morphs)
{
    return fmt::format("{:>8}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.2f}\n", name, mm_per_m * skinning.mean,
                       mm_per_m * skinning.max, mm_per_m * morphs.mean, mm_per_m * morphs.max);
}

}  // namespace

void describe(OptionList& list, RigOptions& options)
{
    list.add(
        "rig", options.kind,
        "What moves the skin in .glb and .usda: its vertices in every frame (none), the skeleton (skinning), or the "
        "skeleton with morphs fitted to the samples (morphs)");
    list.add("influences", options.influences, "Joints that move a vertex of the rig, 4 or 8; the strongest are kept",
             4, 8);
    list.add("morphs", options.morphs, "Morphs of --rig morphs, at most", 1, 256);
}

void RigOptions::check() const
{
    require_input(influences == 4 || influences == 8, "--influences {}: formats hold 4 or 8", influences);
}

BodyRig body_rig(const BodyPoser& poser, const Body& body, const std::vector<Pose>& poses, const RigOptions& options,
                 const std::function<Points(int frame_idx)>& skin)
{
    options.check();
    const Template& shared = poser.body_template();
    BodyRig result;
    result.weights = strongest_weights(shared.skin_weights, options.influences);
    Rig& rig = result.rig;
    rig.rest_vertices = body.skin_vertices;
    rig.joint_names = shared.skeleton.joint_names;
    rig.parents = shared.skeleton.parents;
    rig.joint_positions = body.joint_positions;
    rig.weight_joints = result.weights.joints.leftCols(options.influences);
    rig.weights = result.weights.weights.leftCols(options.influences);
    rig.root_translations.resize(Eigen::Index(poses.size()), 3);
    for (std::size_t f = 0; f < poses.size(); ++f) {
        std::vector<Eigen::Quaterniond>& rotations = rig.rotations.emplace_back();
        for (const Eigen::Matrix3d& rotation : poses[f].parent_from_joint) rotations.emplace_back(rotation);
        rig.root_translations.row(Eigen::Index(f)) = poses[f].root_translation.transpose();
    }
    if (options.kind != RigKind::morphs) return result;
    result.baked = bake_morphs(body.skin_vertices, result.weights, int(poses.size()), options.morphs, [&](int f) {
        return BakedFrame{forward_kinematics(shared.skeleton, body.joint_positions, poses[f]), skin(f)};
    });
    rig.morphs = result.baked.morphs;
    rig.morph_weights = result.baked.weights;
    return result;
}

std::vector<RigClip> pose_clips(const PoseSet& poses, const std::vector<int>& pose_indices)
{
    std::vector<RigClip> clips;
    for (int begin = 0, end = 0; begin < int(pose_indices.size()); begin = end) {
        const int clip_idx = poses.clip_idx[pose_indices[begin]];
        while (end < int(pose_indices.size()) && poses.clip_idx[pose_indices[end]] == clip_idx) ++end;
        const std::vector<int> indices(pose_indices.begin() + begin, pose_indices.begin() + end);
        clips.push_back({poses.clip_names[clip_idx], begin, end, shown_frame_rate(poses, indices)});
    }
    return clips;
}

std::string bake_report(const BodyRig& rig, const RigOptions& options)
{
    return nlohmann::json({{"influences", options.influences},
                           {"morphs", rig.baked.morphs.size()},
                           {"skinning", to_json(rig.baked.skinning_errors)},
                           {"skinning_with_morphs", to_json(rig.baked.errors)}})
               .dump(1) +
           "\n";
}

std::string bake_table(const BakedMorphs& baked, int rows)
{
    const int num_frames = int(baked.errors.size());
    std::set<int> shown;
    for (int row = 0; row < rows; ++row) shown.insert(row * (num_frames - 1) / std::max(1, rows - 1));
    const auto worst = std::max_element(baked.errors.begin(), baked.errors.end(),
                                        [](const FrameError& a, const FrameError& b) { return a.max < b.max; });
    shown.insert(int(worst - baked.errors.begin()));
    std::string text =
        fmt::format("{:>8}{:>20}{:>20}\n{:>8}{:>10}{:>10}{:>10}{:>10}\n", "mm", "skinning alone",
                    fmt::format("{} morphs", baked.morphs.size()), "frame", "mean", "max", "mean", "max");
    for (const int f : shown) text += table_row(std::to_string(f), baked.skinning_errors[f], baked.errors[f]);
    return text + table_row("all", over_all(baked.skinning_errors), over_all(baked.errors));
}

}  // namespace ndg
