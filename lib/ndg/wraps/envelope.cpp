// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/envelope.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {
namespace {

/// Large structures take a coarser grid: their envelope is as smooth as the ball that rolls over them.
constexpr double trunk_spacing_factor = 2.0, front_spacing_factor = 3.0;

/// Joints of spine, pelvis and shoulder girdle.
std::vector<int> trunk_joints()
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<int> joints;
    for (const char* name : {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5", "neck_1", "neck_2",
                             "left_clavicle", "right_clavicle"})
        joints.push_back(skeleton.joint(name));
    return joints;
}

/// By the part's joint, or, where it has none, by what the skin next to it hangs on.
bool belongs_to_trunk(const AnatomyMesh& part, const WrapSkin& skin, const Eigen::VectorXd& trunk_weight)
{
    if (!part.joint.empty()) {
        const std::vector<int> joints = trunk_joints();
        return std::find(joints.begin(), joints.end(), standard_skeleton().joint(part.joint)) != joints.end();
    }
    constexpr Eigen::Index max_samples = 60;
    const Eigen::Index stride = std::max<Eigen::Index>(1, part.vertices.rows() / max_samples);
    double sum = 0.0;
    int samples = 0;
    for (Eigen::Index v = 0; v < part.vertices.rows(); v += stride) {
        Eigen::Index nearest = 0;
        (skin.vertices.rowwise() - part.vertices.row(v)).rowwise().squaredNorm().minCoeff(&nearest);
        sum += trunk_weight[nearest];
        ++samples;
    }
    return sum > 0.5 * samples;
}

/// (height, z) of the spine's joints from the pelvis upwards; the body faces +z.
std::vector<Eigen::Vector2d> spine_line(const Points& joint_positions)
{
    std::vector<Eigen::Vector2d> line;
    for (const char* name : {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5"}) {
        const Eigen::RowVector3d joint = joint_positions.row(standard_skeleton().joint(name));
        line.emplace_back(joint.y(), joint.z());
    }
    return line;
}

double spine_depth(const std::vector<Eigen::Vector2d>& line, double height)
{
    if (height <= line.front()[0]) return line.front()[1];
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        if (height >= line[i + 1][0]) continue;
        const double share = (height - line[i][0]) / (line[i + 1][0] - line[i][0]);
        return line[i][1] + share * (line[i + 1][1] - line[i][1]);
    }
    return line.back()[1];
}

/// Value at a point of a grid that does not reach everywhere: beyond it, at least the distance to the grid is added.
double value_beyond(const ScalarGrid& grid, const Eigen::Vector3d& point)
{
    const Eigen::Vector3d low = grid.box.origin;
    const Eigen::Vector3d high = grid.box.node(grid.box.size[0] - 1, grid.box.size[1] - 1, grid.box.size[2] - 1);
    return grid.at(point) + (point - point.cwiseMax(low).cwiseMin(high)).norm();
}

}  // namespace

WrapEnvelopes wrap_envelopes(const WrapSkin& skin, const std::vector<AnatomyMesh>& anatomy,
                             const EnvelopeOptions& options)
{
    const std::vector<int> joints = trunk_joints();
    Eigen::VectorXd trunk_weight = Eigen::VectorXd::Zero(skin.vertices.rows());
    for (const int joint : joints) trunk_weight += skin.weights.col(joint);

    std::vector<const TriangleMesh*> bones, trunk, all;
    for (const AnatomyMesh& part : anatomy) {
        all.push_back(&part);
        if (part.layer != AnatomyLayer::bone) continue;
        bones.push_back(&part);
        if (belongs_to_trunk(part, skin, trunk_weight)) trunk.push_back(&part);
    }
    require(!bones.empty(), "there is no bone to wrap");

    const double margin = std::max(options.bone_closing, options.muscle_closing) + 3.0 * options.spacing;
    const GridBox box = grid_around(skin.vertices, margin, options.spacing);
    WrapEnvelopes envelopes;
    envelopes.skin = signed_distance_grid(box, skin.vertices, skin.triangles);

    {
        const TriangleMesh mesh = join_meshes(bones);
        envelopes.bone = closing_grid(box, mesh.vertices, mesh.triangles, options.bone_closing);
    }
    ScalarGrid pocket, bridge, belly, neck;
    if (!trunk.empty()) {
        const TriangleMesh mesh = join_meshes(trunk);
        const auto closing = [&](double radius, double spacing) {
            return closing_grid(grid_around(mesh.vertices, radius + 3.0 * spacing, spacing), mesh.vertices,
                                mesh.triangles, radius);
        };
        pocket = closing(options.pocket_closing, trunk_spacing_factor * options.spacing);
        bridge = closing(options.trunk_closing, trunk_spacing_factor * options.spacing);
        belly = closing(options.belly_closing, front_spacing_factor * options.spacing);
        neck = closing(options.neck_closing, front_spacing_factor * options.spacing);
    }
    const std::vector<Eigen::Vector2d> spine = spine_line(skin.joint_positions);
    // Where breastbone and ribs fill the front themselves, both are the same.
    const double breastbone = skin.joint_positions(standard_skeleton().joint("spine_5"), 1);
    {
        const TriangleMesh mesh = join_meshes(all);
        envelopes.muscle = closing_grid(box, mesh.vertices, mesh.triangles, options.muscle_closing);
    }
#pragma omp parallel for schedule(static)
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i) {
                const auto n = static_cast<std::size_t>(box.index(i, j, k));
                const double outside = envelopes.skin.values[n];  // negative in the body
                double bone = envelopes.bone.values[n] - options.bone_dilation * options.spacing;
                if (!trunk.empty()) {
                    const Eigen::Vector3d node = box.node(i, j, k);
                    const double front = std::max(value_beyond(node.y() > breastbone ? neck : belly, node),
                                                  spine_depth(spine, node.y()) - node.z());
                    const double bridged = std::min(value_beyond(bridge, node), front);
                    bone = std::min({bone, std::max(bridged, outside + options.trunk_depth),
                                     std::max(value_beyond(pocket, node), outside + options.pocket_depth)});
                }
                bone = std::max(bone, outside + options.bone_depth);
                const double muscle = std::min(envelopes.muscle.values[n] - options.muscle_dilation * options.spacing,
                                               bone - options.min_thickness);
                envelopes.bone.values[n] = static_cast<float>(bone);
                envelopes.muscle.values[n] = static_cast<float>(std::max(muscle, outside + options.muscle_depth));
            }
    return envelopes;
}

}  // namespace ndg
