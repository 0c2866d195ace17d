// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/skin_segments.h"

#include "ndg/body/skeleton.h"

#include <algorithm>
#include <utility>

namespace ndg {

const std::string& segment_name(SkinSegment segment)
{
    static const std::vector<std::string> names = {"head",           "chest",           "belly",        "hips",
                                                   "left upper arm", "right upper arm", "left forearm", "right forearm",
                                                   "left hand",      "right hand",      "left thigh",   "right thigh",
                                                   "left shin",      "right shin",      "left foot",    "right foot"};
    return names[static_cast<std::size_t>(segment)];
}

std::vector<SkinSegment> skin_segments(const SkinningWeights& weights)
{
    // Joints not named go with their parent.
    const std::vector<std::pair<const char*, SkinSegment>> middle = {{"pelvis", SkinSegment::hips},
                                                                     {"spine_1", SkinSegment::belly},
                                                                     {"spine_4", SkinSegment::chest},
                                                                     {"neck_1", SkinSegment::head}};
    const std::vector<std::pair<const char*, SkinSegment>> left = {
        {"clavicle", SkinSegment::chest},       {"upper_arm", SkinSegment::left_upper_arm},
        {"forearm", SkinSegment::left_forearm}, {"hand", SkinSegment::left_hand},
        {"thigh", SkinSegment::left_thigh},     {"shin", SkinSegment::left_shin},
        {"foot", SkinSegment::left_foot}};
    const Skeleton& skeleton = standard_skeleton();
    std::vector<int> of_joint(skeleton.num_joints(), -1);
    for (const auto& [name, segment] : middle) of_joint[skeleton.joint(name)] = static_cast<int>(segment);
    for (const auto& [name, segment] : left) {
        const int value = static_cast<int>(segment);
        of_joint[skeleton.joint(std::string("left_") + name)] = value;
        of_joint[skeleton.joint(std::string("right_") + name)] = segment == SkinSegment::chest ? value : value + 1;
    }
    for (std::size_t j = 0; j < of_joint.size(); ++j) {
        if (of_joint[j] < 0) of_joint[j] = of_joint[skeleton.parents[j]];
    }
    std::vector<SkinSegment> segments(weights.size());
    for (Eigen::Index v = 0; v < weights.size(); ++v) {
        Eigen::Index slot = 0;
        weights.weights.row(v).maxCoeff(&slot);
        segments[v] = static_cast<SkinSegment>(of_joint[weights.joints(v, slot)]);
    }
    return segments;
}

SegmentPair pair_of(SkinSegment segment)
{
    const int value = static_cast<int>(segment), first_sided = static_cast<int>(SkinSegment::left_upper_arm);
    return static_cast<SegmentPair>(value < first_sided ? value : first_sided + (value - first_sided) / 2);
}

std::vector<char> scalp_vertices(const SkinnedSurface& skin)
{
    const Skeleton& skeleton = standard_skeleton();
    const Eigen::RowVector3d eye = 0.5 * (skin.joint_positions.row(skeleton.joint("left_eye")) +
                                          skin.joint_positions.row(skeleton.joint("right_eye")));
    const Eigen::VectorXd head = subtree_weights(skin.weights, {"head"});
    // Shares of the head's height over the eyes: a hairline 4 cm above them, that falls by 9 mm for each cm further
    // back.
    const double size = skin.vertices.col(1).maxCoeff() - eye[1];
    std::vector<char> scalp(skin.vertices.rows());
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        const double above = (skin.vertices(v, 1) - eye[1]) / size, behind = (eye[2] - skin.vertices(v, 2)) / size;
        scalp[v] = head[v] > 0.5 && above + 0.9 * (behind - 0.55) > 0.36;
    }
    return scalp;
}

}  // namespace ndg
