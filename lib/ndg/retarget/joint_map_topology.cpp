// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/joint_map_topology.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace ndg {

namespace {

using Eigen::Vector3d;

/// Shares of the skeleton's size: a joint this near to the plane of symmetry lies in it; mirror images agree within
/// this; limbs are at least this long.
constexpr double in_plane = 0.012, mirror_tolerance = 0.04, limb_length = 0.25;

class PlanFinder {
public:
    PlanFinder(const MotionClip& clip, const std::vector<JointName>& names)
        : clip_(clip), names_(names), num_(clip.num_joints())
    {
        size_ =
            (clip.zero_pose_positions.colwise().maxCoeff() - clip.zero_pose_positions.colwise().minCoeff()).maxCoeff();
        require_input(size_ > 0.0, "clip {}: all joints of its zero pose are in one place", clip.name);
        // Children follow their parents.
        depth_.assign(std::size_t(num_), 0);
        arc_.assign(std::size_t(num_), 0.0);
        for (int j = 1; j < num_; ++j) {
            depth_[j] = depth_[clip.parents[j]] + 1;
            arc_[j] = arc_[clip.parents[j]] + (position(j) - position(clip.parents[j])).norm();
        }
        reach_ = arc_;
        for (int j = num_ - 1; j >= 0; --j) {
            reach_[j] = std::max(reach_[j], arc_[j] + (tip(j) - position(j)).norm());
            if (j > 0) reach_[clip.parents[j]] = std::max(reach_[clip.parents[j]], reach_[j]);
        }
    }

    BodyPlan find(bool by_lengths)
    {
        pair_by_names();
        plan_.sides_from_names = pairs_.size() >= 4;
        // A pose can make a skeleton longer than a person is.
        if (by_lengths) size_ = std::min(size_, 1.3 * *std::max_element(reach_.begin(), reach_.end()));
        if (!plan_.sides_from_names && by_lengths) pair_by_lengths();
        if (!plan_.sides_from_names && !by_lengths) pair_by_mirror();
        group_limbs();
        find_axes();
        find_trunk();
        return plan_;
    }

private:
    Vector3d position(int j) const { return clip_.zero_pose_positions.row(j).transpose(); }
    Vector3d tip(int j) const { return clip_.zero_pose_tips.row(j).transpose(); }

    bool is_ancestor(int above, int below) const
    {
        while (below > above) below = clip_.parents[below];
        return below == above;
    }

    int common_ancestor(int a, int b) const
    {
        while (a != b) (a > b ? a : b) = clip_.parents[std::max(a, b)];
        return a;
    }

    /// Child of `above` on the way to `below`.
    int child_towards(int above, int below) const
    {
        while (clip_.parents[below] != above) below = clip_.parents[below];
        return below;
    }

    /// Left and right of the same words and numbers.
    void pair_by_names()
    {
        std::map<std::pair<std::string, std::vector<int>>, std::array<int, 2>> found;
        for (int j = 0; j < num_; ++j) {
            const JointName& name = names_[j];
            if (name.side == Side::none) continue;
            auto& pair =
                found.emplace(std::make_pair(name.joined, name.numbers), std::array<int, 2>{-1, -1}).first->second;
            pair[name.side == Side::left ? 0 : 1] = j;
        }
        for (const auto& item : found) {
            if (item.second[0] >= 0 && item.second[1] >= 0) pairs_.push_back(item.second);
        }
    }

    /// Joints at mirrored places of the plane that mirrors most of them, of like depth and length below.
    void pair_by_mirror()
    {
        for (int axis = 0; axis < 3; ++axis) {
            std::vector<std::array<int, 2>> pairs;
            const double centre = position(0)[axis];
            for (int a = 0; a < num_; ++a) {
                Vector3d mirrored = position(a);
                if (mirrored[axis] - centre < in_plane * size_) continue;
                mirrored[axis] = 2.0 * centre - mirrored[axis];
                int best = -1;
                double best_distance = mirror_tolerance * size_;
                for (int b = 0; b < num_; ++b) {
                    const double below = std::abs((reach_[a] - arc_[a]) - (reach_[b] - arc_[b]));
                    const double distance = (position(b) - mirrored).norm() + 0.5 * below;
                    if (depth_[a] == depth_[b] && distance < best_distance) {
                        best = b;
                        best_distance = distance;
                    }
                }
                if (best >= 0) pairs.push_back({a, best});
            }
            if (pairs.size() > pairs_.size()) pairs_ = pairs;
        }
    }

    /// Joints that hang on one joint or on a pair, of like bones and like length below.
    void pair_by_lengths()
    {
        constexpr double tolerance = 0.01;
        std::vector<int> partner(std::size_t(num_), -1);
        for (int a = 1; a < num_; ++a) {
            const int above = clip_.parents[a], other_above = partner[above] >= 0 ? partner[above] : above;
            int best = -1;
            double best_difference = tolerance * size_;
            for (int b = a + 1; b < num_ && partner[a] < 0; ++b) {
                if (clip_.parents[b] != other_above || partner[b] >= 0) continue;
                // A limb is longer than what parts from it in the middle (a finger's neighbour).
                const double below = reach_[a] - arc_[a];
                if (other_above == above && below < limb_length * size_) continue;
                const double difference = std::abs(arc_[a] - arc_[b]) + std::abs(below - (reach_[b] - arc_[b]));
                if (difference >= best_difference) continue;
                best = b;
                best_difference = difference;
            }
            if (best < 0) continue;
            partner[a] = best;
            partner[best] = a;
            pairs_.push_back({a, best});
        }
    }

    struct LimbPair {
        int base = 0;
        std::array<int, 2> start{};
        double length = 0.0;
    };

    /// Pairs of branches that part at one joint. The legs hang on the joint nearest to the root, the arms are the
    /// longest of the others.
    void group_limbs()
    {
        std::map<std::tuple<int, int, int>, LimbPair> groups;
        for (const auto& [a, b] : pairs_) {
            const int base = common_ancestor(a, b);
            if (base == a || base == b) continue;
            LimbPair limb;
            limb.base = base;
            limb.start = {child_towards(base, a), child_towards(base, b)};
            limb.length = std::min(reach_[limb.start[0]], reach_[limb.start[1]]) - arc_[base];
            groups[{base, limb.start[0], limb.start[1]}] = limb;
        }
        std::vector<LimbPair> limbs;
        for (const auto& item : groups) {
            if (item.second.length > limb_length * size_) limbs.push_back(item.second);
        }
        require_input(limbs.size() >= 2, "clip {}: has {} pairs of long mirrored branches, legs and arms are two",
                      clip_.name, limbs.size());
        const auto nearer = [&](const LimbPair& a, const LimbPair& b) {
            return std::make_tuple(depth_[a.base], -a.length) < std::make_tuple(depth_[b.base], -b.length);
        };
        legs_ = *std::min_element(limbs.begin(), limbs.end(), nearer);
        arms_.length = 0.0;
        for (const LimbPair& limb : limbs) {
            if (limb.start != legs_.start && limb.length > arms_.length) arms_ = limb;
        }
    }

    /// Joints from `start` to the leaf whose tip is farthest along the bones.
    std::vector<int> chain(int start) const
    {
        std::vector<int> joints = {start};
        for (int j = start + 1; j < num_; ++j) {
            if (clip_.parents[j] == joints.back() && reach_[j] == reach_[joints.back()]) joints.push_back(j);
        }
        return joints;
    }

    static Vector3d axis_of(const Vector3d& direction)
    {
        Eigen::Index axis = 0;
        direction.cwiseAbs().maxCoeff(&axis);
        return (direction[axis] < 0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
    }

    void find_axes()
    {
        Vector3d across = Vector3d::Zero();
        for (const auto& [a, b] : pairs_) {
            if (is_ancestor(legs_.start[0], a) || is_ancestor(legs_.start[1], a)) across += position(a) - position(b);
        }
        const Vector3d first = axis_of(across);
        Vector3d down = Vector3d::Zero();
        for (const int start : legs_.start) down += tip(chain(start).back()) - position(start);
        down -= down.dot(first) * first;
        plan_.up = -axis_of(down);
        plan_.left = first;
        plan_.front = plan_.left.cross(plan_.up);
        std::array<int, 2> order = {0, 1};
        if (!plan_.sides_from_names) {
            // The feet point forward: from the last joint but one to the tip.
            Vector3d ahead = Vector3d::Zero();
            for (const int start : legs_.start) {
                const std::vector<int> joints = chain(start);
                const double low = tip(joints.back()).dot(plan_.up);
                for (const int j : joints) {
                    if (position(j).dot(plan_.up) - low < 0.15 * size_) {
                        ahead += tip(joints.back()) - position(j);
                        break;
                    }
                }
            }
            if (ahead.dot(plan_.front) < 0.0) {
                plan_.front = -plan_.front;
                plan_.left = -plan_.left;
                order = {1, 0};
            }
        }
        for (std::size_t side = 0; side < 2; ++side) {
            plan_.legs[side] = chain(legs_.start[std::size_t(order[side])]);
            plan_.arms[side] = chain(arms_.start[std::size_t(order[side])]);
        }
        set_shares();
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (int j = 0; j < num_; ++j) {
            for (const Vector3d& point : {position(j), tip(j)}) {
                low = std::min(low, point.dot(plan_.up));
                high = std::max(high, point.dot(plan_.up));
            }
        }
        plan_.ground = low;
        plan_.height = high - low;
    }

    /// From hip to toes a leg's bones are 0.63 of stature (Drillis and Contini 1966: thigh 0.245, shin 0.246; foot),
    /// with the way from the trunk to the hip 0.69.
    void set_shares()
    {
        const double stature = legs_.length / 0.69;
        for (std::size_t side = 0; side < 2; ++side) {
            for (const int j : plan_.legs[side])
                plan_.leg_shares[side].push_back((arc_[j] - arc_[legs_.base]) / stature);
            for (const int j : plan_.arms[side])
                plan_.arm_shares[side].push_back((arc_[j] - arc_[arms_.base]) / stature);
        }
    }

    void find_trunk()
    {
        const int pelvis = common_ancestor(legs_.base, arms_.base);
        for (int j = arms_.base; j != pelvis; j = clip_.parents[j]) plan_.spine.push_back(j);
        plan_.spine.push_back(pelvis);
        std::reverse(plan_.spine.begin(), plan_.spine.end());
        // Upwards from the shoulders, always towards the highest joint, as far as one named head or the last.
        std::vector<double> top(std::size_t(num_), 0.0);
        for (int j = num_ - 1; j >= 0; --j) {
            top[j] = std::max(top[j],
                              std::max(plan_.height_of(position(j).transpose()), plan_.height_of(tip(j).transpose())));
            if (j > 0) top[clip_.parents[j]] = std::max(top[clip_.parents[j]], top[j]);
        }
        int current = arms_.base;
        while (plan_.head.empty() || names_[plan_.head.back()].words != std::vector<std::string>{"head"}) {
            int next = -1;
            for (int j = current + 1; j < num_; ++j) {
                const bool arm = j == arms_.start[0] || j == arms_.start[1];
                const JointName& name = names_[j];
                const bool end = name.has("end") || name.has("nub") || name.has("top") || name.has("eye");
                if (clip_.parents[j] != current || arm || end || name.side != Side::none) continue;
                if (next < 0 || top[j] > top[next]) next = j;
            }
            if (next < 0) break;
            plan_.head.push_back(next);
            current = next;
        }
    }

    const MotionClip& clip_;
    const std::vector<JointName>& names_;
    int num_;
    double size_ = 0.0;
    std::vector<int> depth_;
    std::vector<double> arc_, reach_;  ///< length of bones from the root to a joint, and to the farthest tip below it
    std::vector<std::array<int, 2>> pairs_;
    LimbPair legs_, arms_;
    BodyPlan plan_;
};

}  // namespace

BodyPlan find_body_plan(const MotionClip& clip, const std::vector<JointName>& names, bool by_lengths)
{
    return PlanFinder(clip, names).find(by_lengths);
}

}  // namespace ndg
