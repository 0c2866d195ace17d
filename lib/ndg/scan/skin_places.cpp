// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/skin_places.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// Mean of the vertices weighted by `shares`.
Eigen::Vector3d weighted_centre(const Points& vertices, const Eigen::VectorXd& shares, const char* place)
{
    const double sum = shares.sum();
    require(sum > 0, "the skin has no vertex at the {}", place);
    return (vertices.transpose() * shares) / sum;
}

/// Where arm and trunk meet below the shoulder, on surfaces that look down.
Eigen::Vector3d find_armpit(const SkinnedSurface& skin, const Points& normals, const std::string& side)
{
    const Eigen::VectorXd arm = subtree_weights(skin.weights, {side + "_upper_arm"});
    const Eigen::RowVector3d shoulder = skin.joint_positions.row(standard_skeleton().joint(side + "_upper_arm"));
    Eigen::VectorXd shares = Eigen::VectorXd::Zero(arm.size());
    for (Eigen::Index v = 0; v < arm.size(); ++v) {
        const double mixed = arm[v] * (1.0 - arm[v]);
        if (normals(v, 1) < -0.2 && skin.vertices(v, 1) < shoulder[1]) shares[v] = mixed * -normals(v, 1);
    }
    return weighted_centre(skin.vertices, shares, (side + " armpit").c_str());
}

}  // namespace

Eigen::VectorXd subtree_weights(const SkinningWeights& weights, const std::vector<std::string>& joint_names)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<char> wanted(skeleton.num_joints(), 0);
    for (const std::string& name : joint_names) wanted[skeleton.joint(name)] = 1;
    for (std::size_t j = 0; j < wanted.size(); ++j) {
        const int parent = skeleton.parents[j];
        if (parent >= 0 && wanted[parent]) wanted[j] = 1;
    }
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(weights.size());
    for (Eigen::Index v = 0; v < weights.size(); ++v) {
        for (int k = 0; k < max_influences; ++k) {
            if (wanted[weights.joints(v, k)]) sums[v] += weights.weights(v, k);
        }
    }
    return sums;
}

SkinPlaces find_skin_places(const SkinnedSurface& skin)
{
    const Points normals = vertex_normals(skin.vertices, skin.triangles);
    SkinPlaces places;
    places.left_armpit = find_armpit(skin, normals, "left");
    places.right_armpit = find_armpit(skin, normals, "right");
    places.head_top = skin.vertices.col(1).maxCoeff();

    const Eigen::VectorXd legs = subtree_weights(skin.weights, {"left_thigh", "right_thigh"});
    const Eigen::VectorXd feet = subtree_weights(skin.weights, {"left_foot", "right_foot"});
    const Eigen::VectorXd trunk = subtree_weights(skin.weights, {"spine_1"});
    const double pelvis_x = skin.joint_positions(0, 0);
    const double hip_width = std::abs(skin.joint_positions(standard_skeleton().joint("left_thigh"), 0) -
                                      skin.joint_positions(standard_skeleton().joint("right_thigh"), 0));
    Eigen::VectorXd shares = Eigen::VectorXd::Zero(legs.size());
    for (Eigen::Index v = 0; v < legs.size(); ++v) {
        const bool middle = std::abs(skin.vertices(v, 0) - pelvis_x) < 0.2 * hip_width;
        if (middle && normals(v, 1) < -0.5 && feet[v] < 0.01 && trunk[v] < 0.2) shares[v] = -normals(v, 1);
        if (feet[v] > 0.9 && normals(v, 1) < -0.7) places.sole_vertices.push_back(static_cast<int>(v));
    }
    places.crotch = weighted_centre(skin.vertices, shares, "crotch");
    require(!places.sole_vertices.empty(), "the skin has no vertex at the soles");
    return places;
}

}  // namespace ndg
