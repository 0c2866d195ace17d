// SPDX-License-Identifier: Apache-2.0
#include "ndg/makehuman/rig.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>

namespace ndg {

namespace {

const std::array<const char*, 2> side_names = {"left", "right"};
const std::array<const char*, 2> side_letters = {"l", "r"};
const std::array<const char*, 5> finger_names = {"thumb", "index", "middle", "ring", "pinky"};
constexpr int weight_smoothing_steps = 4;

/// Our joint -> MakeHuman's cube, for the joints that have one.
std::map<std::string, std::string> cube_of_joint()
{
    std::map<std::string, std::string> cubes = {{"pelvis", "joint-pelvis"},   {"spine_1", "joint-spine-4"},
                                                {"spine_2", "joint-spine-3"}, {"spine_3", "joint-spine-2"},
                                                {"spine_5", "joint-spine-1"}, {"neck_1", "joint-neck"},
                                                {"head", "joint-head"},       {"jaw", "joint-mouth"},
                                                {"left_eye", "joint-l-eye"},  {"right_eye", "joint-r-eye"}};
    for (int s = 0; s < 2; ++s) {
        const std::string ours = std::string(side_names[s]) + "_",
                          theirs = std::string("joint-") + side_letters[s] + "-";
        cubes[ours + "clavicle"] = theirs + "clavicle";
        cubes[ours + "upper_arm"] = theirs + "shoulder";
        cubes[ours + "forearm"] = theirs + "elbow";
        cubes[ours + "hand"] = theirs + "hand";
        cubes[ours + "thigh"] = theirs + "upper-leg";
        cubes[ours + "shin"] = theirs + "knee";
        cubes[ours + "foot"] = theirs + "ankle";
        cubes[ours + "toes"] = theirs + "foot-1";
        for (int f = 0; f < 5; ++f)
            for (int k = 1; k <= 3; ++k)
                cubes[ours + finger_names[f] + "_" + std::to_string(k)] =
                    theirs + "finger-" + std::to_string(f + 1) + "-" + std::to_string(k);
    }
    return cubes;
}

/// MakeHuman bone -> the chain of our joints it is divided over, and the joint where the chain ends.
struct Chain {
    std::vector<std::string> joints;
    std::string end;  ///< only used to divide: position of the far end of the last joint's bone
};
std::map<std::string, Chain> chain_of_bone()
{
    std::map<std::string, Chain> chains = {{"Root", {{"pelvis"}, ""}},
                                           {"pelvis", {{"pelvis"}, ""}},
                                           {"spine_01", {{"spine_1"}, ""}},
                                           {"spine_02", {{"spine_2"}, ""}},
                                           {"spine_03", {{"spine_3", "spine_4", "spine_5"}, "neck_1"}},
                                           {"neck_01", {{"neck_1", "neck_2"}, "head"}},
                                           {"head", {{"head"}, ""}}};
    for (int s = 0; s < 2; ++s) {
        const std::string ours = std::string(side_names[s]) + "_", theirs = std::string("_") + side_letters[s];
        chains["clavicle" + theirs] = {{ours + "clavicle"}, ""};
        chains["upperarm" + theirs] = {{ours + "upper_arm"}, ""};
        chains["lowerarm" + theirs] = {{ours + "forearm", ours + "forearm_twist"}, ours + "hand"};
        chains["hand" + theirs] = {{ours + "hand"}, ""};
        chains["thigh" + theirs] = {{ours + "thigh"}, ""};
        chains["calf" + theirs] = {{ours + "shin"}, ""};
        chains["foot" + theirs] = {{ours + "foot"}, ""};
        chains["ball" + theirs] = {{ours + "toes"}, ""};
        for (const char* finger : finger_names)
            for (int k = 1; k <= 3; ++k)
                chains[std::string(finger) + "_0" + std::to_string(k) + theirs] = {
                    {ours + finger + "_" + std::to_string(k)}, ""};
    }
    return chains;
}

/// Shares of a point along a chain: piecewise linear between the middles of the chain's bones, so that neighbouring
/// bones blend over half a bone on either side of the joint.
std::vector<double> chain_shares(const Eigen::RowVector3d& point, const std::vector<Eigen::RowVector3d>& nodes)
{
    const std::size_t count = nodes.size() - 1;
    std::vector<double> shares(count, 0.0);
    const Eigen::RowVector3d axis = nodes.back() - nodes.front();
    const auto along = [&](const Eigen::RowVector3d& x) { return (x - nodes.front()).dot(axis) / axis.squaredNorm(); };
    std::vector<double> middles(count);
    for (std::size_t i = 0; i < count; ++i) middles[i] = along(0.5 * (nodes[i] + nodes[i + 1]));
    const double t = along(point);
    if (t <= middles.front()) {
        shares.front() = 1.0;
    } else if (t >= middles.back()) {
        shares.back() = 1.0;
    } else {
        std::size_t i = 0;
        while (t > middles[i + 1]) ++i;
        const double fraction = (t - middles[i]) / (middles[i + 1] - middles[i]);
        shares[i] = 1.0 - fraction;
        shares[i + 1] = fraction;
    }
    return shares;
}

}  // namespace

Points makehuman_joint_positions(const Eigen::Ref<const Points>& all_vertices,
                                 const std::map<std::string, std::vector<int>>& joint_cubes)
{
    const Skeleton& skeleton = standard_skeleton();
    Points positions = Points::Zero(skeleton.num_joints(), 3);
    for (const auto& [joint, cube] : cube_of_joint()) {
        const auto found = joint_cubes.find(cube);
        require_input(found != joint_cubes.end(), "MakeHuman's base mesh has no group '{}', needed for joint {}", cube,
                      joint);
        for (const int vertex : found->second) positions.row(skeleton.joint(joint)) += all_vertices.row(vertex);
        positions.row(skeleton.joint(joint)) /= static_cast<double>(found->second.size());
    }
    const auto between = [&](const std::string& joint, const std::string& a, const std::string& b, double fraction) {
        positions.row(skeleton.joint(joint)) =
            (1.0 - fraction) * positions.row(skeleton.joint(a)) + fraction * positions.row(skeleton.joint(b));
    };
    between("spine_4", "spine_3", "spine_5", 0.5);
    between("neck_2", "neck_1", "head", 0.5);
    for (const char* side : side_names)
        between(std::string(side) + "_forearm_twist", std::string(side) + "_forearm", std::string(side) + "_hand", 0.5);
    return positions;
}

RowMatrix makehuman_weights(const std::string& path, const Eigen::Ref<const Points>& vertices,
                            const Eigen::Ref<const Triangles>& triangles,
                            const Eigen::Ref<const Points>& joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto chains = chain_of_bone();
    RowMatrix weights = RowMatrix::Zero(vertices.rows(), skeleton.num_joints());
    for (const auto& [bone, entries] : JsonValue(path).at("weights").members()) {
        const auto chain = chains.find(bone);
        require_input(chain != chains.end(), "{}: unknown bone", entries.where());
        std::vector<int> joints;
        std::vector<Eigen::RowVector3d> nodes;
        for (const std::string& name : chain->second.joints) {
            joints.push_back(skeleton.joint(name));
            nodes.emplace_back(joint_positions.row(joints.back()));
        }
        if (!chain->second.end.empty()) nodes.emplace_back(joint_positions.row(skeleton.joint(chain->second.end)));
        for (const JsonValue& entry : entries.elements()) {
            const std::vector<JsonValue> pair = entry.elements(2);
            const int vertex = pair[0].integer(0);
            const double weight = pair[1].number(0.0);
            if (vertex >= vertices.rows()) continue;  // helper geometry, not part of the body
            if (joints.size() == 1) {
                weights(vertex, joints[0]) += weight;
            } else {
                const std::vector<double> shares = chain_shares(vertices.row(vertex), nodes);
                for (std::size_t i = 0; i < joints.size(); ++i) weights(vertex, joints[i]) += weight * shares[i];
            }
        }
    }
    const Eigen::VectorXd sums = weights.rowwise().sum();
    for (Eigen::Index v = 0; v < weights.rows(); ++v)
        require_input(sums[v] > 1e-6, "{}: body vertex {} has no weight", path, v);
    weights.array().colwise() /= sums.array();
    const auto neighbours = vertex_neighbours(triangles, static_cast<int>(vertices.rows()));
    for (int step = 0; step < weight_smoothing_steps; ++step) {
        RowMatrix smoothed = weights;
        for (Eigen::Index v = 0; v < weights.rows(); ++v) {
            if (neighbours[v].empty()) continue;
            Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(weights.cols());
            for (const int n : neighbours[v]) mean += weights.row(n);
            smoothed.row(v) = 0.5 * weights.row(v) + 0.5 * mean / static_cast<double>(neighbours[v].size());
        }
        weights = smoothed;
    }
    return weights;
}

}  // namespace ndg
