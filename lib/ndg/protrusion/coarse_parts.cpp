// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/coarse_parts.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_crossings.h"

#include <algorithm>
#include <vector>

namespace ndg {

namespace {

constexpr double core_weight = 0.9;

/// 0 for trunk and head, 1 to 4 for the limbs: of every joint.
std::vector<int> parts_of_joints(const Skeleton& skeleton)
{
    const std::array<const char*, 4> limbs = {"left_upper_arm", "right_upper_arm", "left_thigh", "right_thigh"};
    std::vector<int> parts(skeleton.num_joints(), 0);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const auto limb = std::find(limbs.begin(), limbs.end(), skeleton.joint_names[j]);
        if (limb != limbs.end()) {
            parts[j] = 1 + int(limb - limbs.begin());
        } else if (skeleton.parents[j] >= 0) {
            parts[j] = parts[skeleton.parents[j]];
        }
    }
    for (int part = 1; part < CoarseParts::count; ++part)
        require_input(std::find(parts.begin(), parts.end(), part) != parts.end(), "the skeleton has no joint {}",
                      limbs[part - 1]);
    return parts;
}

}  // namespace

CoarseParts::CoarseParts(const Template& body_template)
{
    const std::vector<int> joint_parts = parts_of_joints(body_template.skeleton);
    const SkinningWeights& weights = body_template.skin_weights;
    std::vector<int> vertex_parts(weights.joints.rows(), -1);
    for (Eigen::Index v = 0; v < weights.joints.rows(); ++v) {
        std::array<double, count> sums{};
        for (Eigen::Index k = 0; k < weights.joints.cols(); ++k)
            sums[joint_parts[weights.joints(v, k)]] += weights.weights(v, k);
        for (int part = 0; part < count; ++part)
            if (sums[part] >= core_weight) vertex_parts[v] = part;
    }
    std::array<std::vector<Eigen::RowVector3i>, count> lists;
    for (Eigen::Index t = 0; t < body_template.skin_triangles.rows(); ++t) {
        const Eigen::RowVector3i corners = body_template.skin_triangles.row(t);
        const int part = vertex_parts[corners[0]];
        if (part >= 0 && vertex_parts[corners[1]] == part && vertex_parts[corners[2]] == part)
            lists[part].push_back(corners);
    }
    for (int part = 0; part < count; ++part) {
        triangles_[part].resize(lists[part].size(), 3);
        for (std::size_t t = 0; t < lists[part].size(); ++t) triangles_[part].row(t) = lists[part][t];
    }
}

bool CoarseParts::collide(const Eigen::Ref<const Points>& skin_vertices) const
{
    for (int a = 0; a < count; ++a)
        for (int b = a + 1; b < count; ++b)
            if (!crossing_triangles(skin_vertices, triangles_[a], skin_vertices, triangles_[b]).empty()) return true;
    return false;
}

}  // namespace ndg
