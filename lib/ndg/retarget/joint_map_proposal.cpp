// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/joint_map_proposal.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/retarget/joint_map_names.h"
#include "ndg/retarget/joint_map_roles.h"
#include "ndg/retarget/joint_map_topology.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ndg {

namespace {

constexpr double degree = M_PI / 180.0;

/// A hand that is further from its forearm at rest, or a foot nearer to its shank's direction, shows no rest pose.
constexpr double largest_tip_angle = 60 * degree, least_foot_angle = 25 * degree;

class Proposer {
public:
    Proposer(const MotionClip& clip, bool by_lengths)
        : clip_(clip),
          names_(parse_joint_names(clip.joint_names)),
          plan_(find_body_plan(clip, names_, by_lengths)),
          by_lengths_(by_lengths)
    {
        result_.map.path = clip.name + " (proposed)";
        result_.sides_from_names = plan_.sides_from_names;
    }

    JointMapProposal propose()
    {
        if (!plan_.sides_from_names) note("left and right are guessed from where the feet point");
        add({"pelvis", name(plan_.spine.front())});
        add_trunk();
        for (const std::size_t side : {std::size_t(0), std::size_t(1)}) {
            add_arm(side);
            add_leg(side);
        }
        add_face();
        return result_;
    }

private:
    const std::string& name(int joint) const { return clip_.joint_names[std::size_t(joint)]; }
    Eigen::RowVector3d position(int joint) const { return clip_.zero_pose_positions.row(joint); }
    void note(const std::string& text) { result_.notes.push_back(text); }
    static std::string prefix(std::size_t side) { return side == 0 ? "left_" : "right_"; }

    struct Entry {
        std::string joint, source;
    };
    JointMapEntry& add(const Entry& entry)
    {
        JointMapEntry mapped;
        mapped.joint = entry.joint;
        mapped.source = entry.source;
        result_.map.entries.push_back(mapped);
        return result_.map.entries.back();
    }

    /// The rotation `t` joints along a chain of the source.
    void add_along(const std::string& joint, const std::vector<int>& chain, double t)
    {
        const auto i = std::min(chain.size() - 1, static_cast<std::size_t>(t + 1e-9));
        JointMapEntry& entry = add({joint, name(chain[i])});
        const double fraction = t - static_cast<double>(i);
        if (fraction < 1e-6) return;
        entry.blend_with = name(chain[i + 1]);
        entry.fraction = std::round(100.0 * fraction) / 100.0;
    }

    void add_trunk()
    {
        const auto num_spine = static_cast<double>(plan_.spine.size() - 1);
        if (num_spine == 0) {
            note("the arms hang on the same joint as the legs: the spine stays straight");
        } else {
            for (int k = 1; k <= 5; ++k) add_along("spine_" + std::to_string(k), plan_.spine, k * num_spine / 5.0);
        }
        if (plan_.head.empty()) {
            note("no neck and no head were found");
            return;
        }
        std::vector<int> neck = {plan_.spine.back()};
        neck.insert(neck.end(), plan_.head.begin(), plan_.head.end());
        const auto num_neck = static_cast<double>(plan_.head.size() - 1);
        for (int k = 1; k <= 2; ++k) {
            add_along("neck_" + std::to_string(k), neck, num_neck > 0 ? 0.5 * k * num_neck : 0.4 * k);
        }
        add({"head", name(plan_.head.back())});
    }

    static double angle_between(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b)
    {
        return std::atan2(Eigen::Vector3d(a).cross(Eigen::Vector3d(b)).norm(), a.dot(b));
    }

    /// `above`: where the bone before begins, along which the bone of a hand or limb goes on; -1: anywhere.
    void align(JointMapEntry& entry, const std::string& toward, int from, int to, int above = -1)
    {
        const Eigen::RowVector3d end = to >= 0 ? position(to) : Eigen::RowVector3d(clip_.zero_pose_tips.row(from));
        const Eigen::RowVector3d bone = end - position(from);
        if (bone.norm() < 1e-4 * plan_.height) return;
        if (above >= 0) {
            const double angle = angle_between(bone, position(from) - position(above));
            if (angle > largest_tip_angle) {
                note(fmt::format(
                    "{}: the bone of {} lies {:.0f} degrees off the one before, more than {:.0f}: not aligned",
                    entry.joint, name(from), angle / degree, largest_tip_angle / degree));
                return;
            }
        }
        entry.toward = toward;
        entry.bone_from = name(from);
        entry.bone_to = to >= 0 ? name(to) : "";
    }

    void add_arm(std::size_t side)
    {
        const std::vector<int>& chain = plan_.arms[side];
        std::vector<double> places;
        double along = std::abs((position(chain[0]) - position(plan_.spine.front())).dot(plan_.left));
        for (std::size_t i = 0; i < chain.size(); ++i) {
            if (i > 0) along += (position(chain[i]) - position(chain[i - 1])).norm();
            places.push_back(along / plan_.height);
        }
        if (by_lengths_) places = plan_.arm_shares[side];
        const std::vector<int> found = find_roles(arm_roles(), chain, places, names_);
        const std::string s = prefix(side);
        if (found.empty()) {
            note("no upper arm and forearm were found along " + name(chain[0]));
            return;
        }
        const int clavicle = found[0], upper = found[1], fore = found[2], hand = found[3];
        if (clavicle >= 0) add({s + "clavicle", name(clavicle)});
        JointMapEntry& upper_entry = add({s + "upper_arm", name(upper)});
        upper_entry.limit = 160 * degree;
        align(upper_entry, s + "forearm", upper, fore);
        align(add({s + "forearm", name(fore)}), s + "hand", fore, hand);
        if (hand < 0) {
            note("no hand was found below " + name(fore));
            return;
        }
        add_forearm_twist(s, chain, fore, hand);
        const int middle = add_fingers(s, hand);
        // The hand's own entry stands before its fingers'.
        JointMapEntry entry;
        entry.joint = s + "hand";
        entry.source = name(hand);
        align(entry, s + "middle_1", hand, middle, fore);
        const auto first_finger = std::find_if(
            result_.map.entries.begin(), result_.map.entries.end(),
            [&](const auto& e) { return e.joint.rfind(s, 0) == 0 && e.joint.back() >= '1' && e.joint.back() <= '3'; });
        result_.map.entries.insert(first_finger, entry);
    }

    void add_forearm_twist(const std::string& s, const std::vector<int>& chain, int fore, int hand)
    {
        const auto f = std::find(chain.begin(), chain.end(), fore), h = std::find(chain.begin(), chain.end(), hand);
        if (h - f >= 2) {
            add({s + "forearm_twist", name(*(f + (h - f) / 2))});
            return;
        }
        JointMapEntry& twist = add({s + "forearm_twist", name(fore)});
        twist.blend_with = name(hand);
        twist.fraction = 0.5;
        twist.twist_only = true;
    }

    /// Joints below the hand named after a finger or numbered 1 to 5 from the thumb; those with three of them at least.
    /// Returns the first of the middle finger, -1 where there is none.
    int add_fingers(const std::string& s, int hand)
    {
        const std::vector<std::pair<std::string, std::vector<std::string>>> fingers = {
            {"thumb", {"thumb"}},
            {"index", {"index", "point"}},
            {"middle", {"mid"}},
            {"ring", {"ring"}},
            {"pinky", {"pinky", "little", "small"}}};
        int middle = -1;
        for (std::size_t f = 0; f < fingers.size(); ++f) {
            std::vector<int> joints;
            for (int j = hand + 1; j < clip_.num_joints(); ++j) {
                int above = j;
                while (above > hand) above = clip_.parents[std::size_t(above)];
                const JointName& parsed = names_[std::size_t(j)];
                const auto has = [&](const std::string& word) { return parsed.has(word); };
                const bool named = std::any_of(fingers[f].second.begin(), fingers[f].second.end(), has);
                const bool numbered = parsed.joined == "finger" && parsed.numbers.size() == 2 &&
                                      parsed.numbers[0] == static_cast<int>(f) + 1;
                const bool other = parsed.has("metacarpal") || parsed.has("end") || parsed.has("nub");
                if (above == hand && (named || numbered) && !other) joints.push_back(j);
            }
            if (joints.size() < 3) continue;
            for (std::size_t k = 0; k < 3; ++k)
                add({s + fingers[f].first + "_" + std::to_string(k + 1), name(joints[k])});
            if (fingers[f].first == "middle") middle = joints[0];
        }
        return middle;
    }

    void add_leg(std::size_t side)
    {
        const std::vector<int>& chain = plan_.legs[side];
        std::vector<double> places;
        for (std::size_t i = 0; i < chain.size(); ++i) {
            // From the trunk down, which is a little above the hips.
            constexpr double base = 0.58;
            places.push_back(by_lengths_ ? std::max(0.0, base - plan_.leg_shares[side][i])
                                         : plan_.height_of(position(chain[i])));
        }
        const std::vector<int> found = find_roles(leg_roles(), chain, places, names_);
        require_input(!found.empty(), "clip {}: no hip, knee and ankle were found along \"{}\"", clip_.name,
                      name(chain[0]));
        const std::string s = prefix(side);
        const int thigh = found[0], shin = found[1], foot = found[2], toes = found[3];
        JointMapEntry& thigh_entry = add({s + "thigh", name(thigh)});
        thigh_entry.limit = 150 * degree;
        align(thigh_entry, s + "shin", thigh, shin);
        align(add({s + "shin", name(shin)}), s + "foot", shin, foot);
        JointMapEntry& foot_entry = add({s + "foot", name(foot)});
        foot_entry.limit = 80 * degree;
        const Eigen::RowVector3d shank = (position(shin) - position(foot)).normalized();
        const Eigen::RowVector3d end = toes >= 0 ? position(toes) : Eigen::RowVector3d(clip_.zero_pose_tips.row(foot));
        const Eigen::RowVector3d sole = end - position(foot);
        const double down = angle_between(sole, -shank);
        const bool forward = down > least_foot_angle && sole.dot(plan_.front) > 0.0;
        if (forward || by_lengths_) {
            align(foot_entry, s + "toes", foot, toes);
        } else if (sole.norm() > 1e-4 * plan_.height) {
            note(fmt::format(
                "{}foot: the bone of {} points {:.0f} degrees off the shank's direction and {}: not aligned", s,
                name(foot), down / degree, sole.dot(plan_.front) > 0.0 ? "forward" : "not forward"));
        }
        foot_entry.sole = !foot_entry.toward.empty();
        // A zero pose with splayed legs has feet square to the shanks instead of flat on a floor.
        if (foot_entry.sole && shank.dot(plan_.up) < std::cos(10 * degree)) {
            foot_entry.up_from = name(foot);
            foot_entry.up_to = name(shin);
            note("the legs are splayed at the zero pose: the sole of " + name(foot) + " is taken square to the shank");
        }
        if (toes >= 0) add({s + "toes", name(toes)}).limit = 70 * degree;
    }

    void add_face()
    {
        for (int j = 0; j < clip_.num_joints(); ++j) {
            const JointName& parsed = names_[std::size_t(j)];
            const bool eye = parsed.words == std::vector<std::string>{"eye"};
            if (parsed.words == std::vector<std::string>{"jaw"} && parsed.side == Side::none) add({"jaw", name(j)});
            if (eye && parsed.side == Side::left) add({"left_eye", name(j)});
            if (eye && parsed.side == Side::right) add({"right_eye", name(j)});
        }
    }

    const MotionClip& clip_;
    std::vector<JointName> names_;
    BodyPlan plan_;
    bool by_lengths_;
    JointMapProposal result_;
};

}  // namespace

namespace {

/// A zero pose that faces or leans off its axes is looked at along them.
JointMapProposal upright_proposal(const MotionClip& clip, const JointMapProposal& at_zero)
{
    MotionClip posed = clip;
    const StanceJoints joints = stance_joints(clip, at_zero.map);
    const Eigen::Vector3d trunk = stance_of(joints, clip.zero_pose_positions).trunk;
    Eigen::Index axis = 0;
    trunk.cwiseAbs().maxCoeff(&axis);
    const Eigen::Vector3d up = (trunk[axis] < 0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(axis);
    turn_clip(posed, minimal_rotation(up, Eigen::Vector3d::UnitY()));
    if (straighten_zero_pose(posed, joints, true) == 0.0) return at_zero;
    return Proposer(posed, false).propose();
}

}  // namespace

JointMapProposal propose_joint_map(const MotionClip& clip, int reference_frame)
{
    const auto stands = [](const MotionClip& posed, const JointMapProposal& proposal) {
        return stance_of(stance_joints(posed, proposal.map), posed.zero_pose_positions).stands();
    };
    std::optional<JointMapProposal> at_zero;
    if (reference_frame < 0) {
        try {
            at_zero = Proposer(clip, false).propose();
            if (clip.axes_known || reference_frame == zero_pose_is_reference) return *at_zero;
            if (stands(clip, *at_zero)) return upright_proposal(clip, *at_zero);
        } catch (const InputError&) {
            if (reference_frame == zero_pose_is_reference) throw;
        }
    }
    const JointMapProposal by_lengths = Proposer(clip, true).propose();
    const ReferencePose reference =
        find_reference_pose(clip, stance_joints(clip, by_lengths.map), reference_frame, std::nullopt);
    if (reference.frame_idx < 0) return at_zero ? *at_zero : by_lengths;
    MotionClip posed = clip;
    set_zero_pose(posed, std::vector<Eigen::Matrix3d>(clip.world_from_joint[reference.frame_idx]));
    turn_clip(posed, minimal_rotation(reference.up, Eigen::Vector3d::UnitY()));
    straighten_zero_pose(posed, stance_joints(posed, by_lengths.map), false);
    JointMapProposal proposal = Proposer(posed, false).propose();
    proposal.reference = fmt::format("frame {}", reference.frame_idx);
    proposal.notes.insert(proposal.notes.begin(),
                          fmt::format("the zero pose is no person who stands straight: {} stands for it{}",
                                      proposal.reference, reference.stands ? "" : ", though it does not stand either"));
    return proposal;
}

}  // namespace ndg
