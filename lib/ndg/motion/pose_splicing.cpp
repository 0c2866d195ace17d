// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/pose_splicing.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/surface_pairs.h"
#include "ndg/motion/pose_sampling.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <string>

namespace ndg {
namespace {

enum class BodyPart { trunk, arms, legs };

bool ends_with_any(const std::string& name, const std::vector<std::string>& ends)
{
    return std::any_of(ends.begin(), ends.end(), [&](const std::string& end) {
        return name.size() >= end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
    });
}

/// Of each joint: where its rotation comes from.
std::vector<BodyPart> body_parts(const Skeleton& skeleton)
{
    std::vector<BodyPart> parts(skeleton.num_joints(), BodyPart::trunk);
    for (int j = 1; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[j];
        parts[j] = ends_with_any(name, {"_clavicle"}) ? BodyPart::arms
                   : ends_with_any(name, {"_thigh"})  ? BodyPart::legs
                                                      : parts[skeleton.parents[j]];
    }
    return parts;
}

/// Skin vertices that some of the joints move more than any other joint.
std::vector<Eigen::Vector3d> skin_of(const Template& body_template, const std::vector<char>& joints)
{
    std::vector<Eigen::Vector3d> points;
    const SkinningWeights& weights = body_template.skin_weights;
    for (Eigen::Index v = 0; v < weights.size(); ++v) {
        Eigen::Index largest = 0;
        weights.weights.row(v).maxCoeff(&largest);
        if (joints[weights.joints(v, largest)]) points.push_back(body_template.rest.skin_vertices.row(v).transpose());
    }
    return points;
}

double median_distance(const std::vector<Eigen::Vector3d>& points, const Points& ends,
                       const std::vector<std::array<int, 2>>& segments)
{
    std::vector<double> beside, all;
    for (const Eigen::Vector3d& point : points) {
        const ClosestOnSegments closest = closest_on_segments(ends, segments, point);
        all.push_back((point - closest.point).norm());
        if (closest.share > 0.0 && closest.share < 1.0) beside.push_back(all.back());
    }
    std::vector<double>& distances = beside.empty() ? all : beside;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
}

}  // namespace

LimbCapsules::LimbCapsules(const Template& body_template)
    : skeleton_(body_template.skeleton), joint_positions_(body_template.rest.joint_positions)
{
    const auto at = [&](const std::string& name) {
        const int joint = skeleton_.joint(name);
        return End{joint, joint_positions_.row(joint).transpose()};
    };
    // Joints from `top` down, without those from `below` down.
    const auto joints_below = [&](const std::string& top, const std::vector<std::string>& below) {
        std::vector<char> member(skeleton_.num_joints(), 0);
        for (int j = skeleton_.joint(top); j < skeleton_.num_joints(); ++j) {
            const std::string& name = skeleton_.joint_names[j];
            const bool cut = std::find(below.begin(), below.end(), name) != below.end();
            member[j] = name == top || (!cut && skeleton_.parents[j] >= 0 && member[skeleton_.parents[j]]);
        }
        return member;
    };
    const auto skin = [&](const std::string& top, const std::vector<std::string>& below) {
        std::vector<Eigen::Vector3d> points = skin_of(body_template, joints_below(top, below));
        require(!points.empty(), "no skin of the template follows joint '{}'", top);
        return points;
    };
    // One part of the body; returns the indices of its capsules.
    const auto add = [&](const std::vector<std::array<End, 2>>& ends, const std::vector<Eigen::Vector3d>& points) {
        Points corners(2 * static_cast<Eigen::Index>(ends.size()), 3);
        std::vector<std::array<int, 2>> segments;
        for (int k = 0; k < static_cast<int>(ends.size()); ++k) {
            for (int e = 0; e < 2; ++e) corners.row(2 * k + e) = ends[k][e].rest.transpose();
            segments.push_back({2 * k, 2 * k + 1});
        }
        const double radius = median_distance(points, corners, segments);
        std::vector<int> added;
        for (const auto& [begin, end] : ends) {
            added.push_back(static_cast<int>(capsules_.size()));
            capsules_.push_back({begin, end, radius});
        }
        return added;
    };
    // From a joint through the middle of its skin, as far again by `factor`.
    const auto through = [&](const std::string& joint, const std::vector<Eigen::Vector3d>& points, double factor) {
        Eigen::Vector3d middle = Eigen::Vector3d::Zero();
        for (const Eigen::Vector3d& point : points) middle += point / static_cast<double>(points.size());
        End end = at(joint);
        end.rest += factor * (middle - end.rest);
        return std::array<End, 2>{at(joint), end};
    };

    const std::vector<std::string> off_trunk = {"neck_1", "left_upper_arm", "right_upper_arm", "left_thigh",
                                                "right_thigh"};
    std::vector<int> core = add({{at("pelvis"), at("neck_1")},
                                 {at("left_thigh"), at("left_upper_arm")},
                                 {at("right_thigh"), at("right_upper_arm")}},
                                skin("pelvis", off_trunk));
    const std::vector<Eigen::Vector3d> head = skin("head", {});
    core.push_back(add({through("head", head, 1.0)}, head).front());
    std::vector<int> arms, legs;
    for (const std::string side : {"left_", "right_"}) {
        arms.push_back(
            add({{at(side + "forearm"), at(side + "hand")}}, skin(side + "forearm", {side + "hand"})).front());
        const std::vector<Eigen::Vector3d> hand = skin(side + "hand", {});
        arms.push_back(add({through(side + "hand", hand, 1.5)}, hand).front());
        End half = at(side + "thigh");
        half.rest = 0.5 * (half.rest + at(side + "shin").rest);
        legs.push_back(add({{half, at(side + "shin")}}, skin(side + "thigh", {side + "shin"})).front());
        legs.push_back(add({{at(side + "shin"), at(side + "foot")}}, skin(side + "shin", {side + "foot"})).front());
    }
    for (const int limb : arms) {
        for (const int other : core) pairs_.emplace_back(limb, other);
        for (const int other : legs) pairs_.emplace_back(limb, other);
    }
    for (const int limb : legs)
        for (const int other : core) pairs_.emplace_back(limb, other);
}

double LimbCapsules::overlap(const Pose& pose) const
{
    const std::vector<Eigen::Isometry3d> world_from_rest = forward_kinematics(skeleton_, joint_positions_, pose);
    const auto posed = [&](const End& end) -> Eigen::RowVector3d {
        return (world_from_rest[end.joint] * end.rest).transpose();
    };
    double deepest = 0.0;
    for (const auto& [a, b] : pairs_) {
        PairCorners corners;
        corners << posed(capsules_[a].begin), posed(capsules_[a].end), posed(capsules_[b].begin),
            posed(capsules_[b].end);
        const double distance = std::sqrt(PairDistance(PairKind::edge_edge, corners).squared());
        deepest = std::max(deepest, capsules_[a].radius + capsules_[b].radius - distance);
    }
    return deepest;
}

SplicedPoses splice_poses(const std::vector<Pose>& poses, const Template& body_template, int count, std::uint64_t seed,
                          double allowed_overlap)
{
    constexpr int max_draws = 100;
    require_input(poses.size() >= 2, "poses are spliced from at least two, there is {}", poses.size());
    const LimbCapsules capsules(body_template);
    const std::vector<BodyPart> parts = body_parts(body_template.skeleton);
    for (const Pose& pose : poses)
        require_input(pose.parent_from_joint.size() == parts.size(), "a pose has {} joints where the template has {}",
                      pose.parent_from_joint.size(), parts.size());
    std::vector<double> overlaps(poses.size());
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < poses.size(); ++i) overlaps[i] = capsules.overlap(poses[i]);

    SplicedPoses result;
    result.poses.resize(count);
    result.sources.resize(count);
    std::atomic<int> failed{0};
#pragma omp parallel for schedule(dynamic, 16)
    for (int i = 0; i < count; ++i) {
        Random random(seed, "spliced poses", static_cast<std::uint64_t>(i));
        for (int draw = 0;; ++draw) {
            if (draw == max_draws) {
                ++failed;
                break;
            }
            std::array<int, 3> sources{};
            for (int& source : sources) source = static_cast<int>(random.below(poses.size()));
            if (sources[0] == sources[1] && sources[0] == sources[2]) continue;
            Pose pose = poses[sources[0]];
            double allowed = allowed_overlap;
            for (const int source : sources) allowed = std::max(allowed, overlaps[source]);
            for (std::size_t j = 0; j < parts.size(); ++j)
                pose.parent_from_joint[j] = poses[sources[static_cast<std::size_t>(parts[j])]].parent_from_joint[j];
            if (capsules.overlap(pose) > allowed) continue;
            result.poses[i] = std::move(pose);
            result.sources[i] = sources;
            break;
        }
    }
    require_input(failed == 0, "{} of {} spliced poses were not found in {} draws each: limbs overlap in all",
                  failed.load(), count, max_draws);
    return result;
}

void append_spliced(PoseSet& kept, const PoseSet& poses, const Template& body_template, const std::vector<int>& marked,
                    int count, std::uint64_t seed)
{
    constexpr int drawn_for_one = 4;
    constexpr double frame_rate = 30.0;  // of a clip that no one moved through
    const int num_kept = kept.size();
    const SplicedPoses spliced = splice_poses(poses.poses, body_template, drawn_for_one * count, seed);
    std::vector<Pose> candidates = kept.poses;
    candidates.insert(candidates.end(), spliced.poses.begin(), spliced.poses.end());
    std::vector<int> first(num_kept);
    std::iota(first.begin(), first.end(), 0);
    const PoseSampling sampling =
        farthest_point_sampling(with_marked_joints(std::move(candidates), marked), num_kept + count, first);

    kept.spliced_from.setConstant(num_kept + count, 6, -1);
    for (int k = 0; k < count; ++k) {
        const int idx = sampling.order[num_kept + k] - num_kept;
        kept.poses.push_back(spliced.poses[idx]);
        kept.clip_idx.push_back(static_cast<int>(kept.clip_names.size()));
        kept.frame_idx.push_back(idx);
        kept.covering_radius.push_back(sampling.covering_radius[num_kept + k]);
        for (int part = 0; part < 3; ++part) {
            const int source = spliced.sources[idx][part];
            kept.spliced_from(num_kept + k, 2 * part) = poses.clip_idx[source];
            kept.spliced_from(num_kept + k, 2 * part + 1) = poses.frame_idx[source];
        }
    }
    kept.clip_names.emplace_back("spliced");
    kept.clip_frame_rates.push_back(frame_rate);
}

}  // namespace ndg
