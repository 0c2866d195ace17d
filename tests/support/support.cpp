// SPDX-License-Identifier: Apache-2.0
#include "support/support.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace ndg::test {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double bone_radius = 0.03, muscle_radius = 0.06, skin_radius = 0.08, tube_height = 1.0;

/// rings x segments points around the y axis, from y_low to y_high.
Points cylinder_points(int rings, int segments, double radius, double y_low, double y_high)
{
    Points points(rings * segments, 3);
    for (int i = 0; i < rings; ++i) {
        for (int s = 0; s < segments; ++s) {
            const double angle = 2.0 * pi * s / segments;
            points.row(i * segments + s) << radius * std::cos(angle), y_low + (y_high - y_low) * i / (rings - 1),
                radius * std::sin(angle);
        }
    }
    return points;
}

/// Outward lateral triangles of such rings of vertices.
Triangles lateral_triangles(int rings, int segments)
{
    Triangles triangles(2 * (rings - 1) * segments, 3);
    Eigen::Index row = 0;
    for (int i = 0; i + 1 < rings; ++i) {
        for (int s = 0; s < segments; ++s) {
            const int a = i * segments + s, d = i * segments + (s + 1) % segments;
            const int b = a + segments, c = d + segments;
            triangles.row(row++) << a, b, d;
            triangles.row(row++) << b, c, d;
        }
    }
    return triangles;
}

/// The lateral triangles and two fans, around the vertices rings * segments (bottom) and the one after it (top).
Triangles closed_triangles(int rings, int segments)
{
    const Triangles lateral = lateral_triangles(rings, segments);
    Triangles triangles(lateral.rows() + 2 * segments, 3);
    triangles.topRows(lateral.rows()) = lateral;
    Eigen::Index row = lateral.rows();
    const int bottom_centre = rings * segments, top_centre = bottom_centre + 1, top = (rings - 1) * segments;
    for (int s = 0; s < segments; ++s) {
        const int next = (s + 1) % segments;
        triangles.row(row++) << bottom_centre, s, next;
        triangles.row(row++) << top_centre, top + next, top + s;
    }
    return triangles;
}

Points append_rows(const Points& above, const Points& below)
{
    Points points(above.rows() + below.rows(), 3);
    points << above, below;
    return points;
}

/// Ring vertices and the two cap centres.
Points closed_cylinder_points(int rings, int segments, double radius, double y_low, double y_high)
{
    Points centres(2, 3);
    centres << 0, y_low, 0, 0, y_high, 0;
    return append_rows(cylinder_points(rings, segments, radius, y_low, y_high), centres);
}

/// Tetrahedra between bone wrap and axis. The diagonals on the wrap are those of its triangles, and on every face
/// between neighbours they run from the axis upwards, so neighbours match.
Tetrahedra axis_tetrahedra(int rings, int segments, const Points& wrap, const Points& axis)
{
    Tetrahedra tetrahedra(3 * (rings - 1) * segments, 4);
    const int num_wrap = rings * segments;
    Eigen::Index row = 0;
    for (int i = 0; i + 1 < rings; ++i) {
        for (int s = 0; s < segments; ++s) {
            const int a = i * segments + s, d = i * segments + (s + 1) % segments;
            const int b = a + segments, c = d + segments;
            const int low = num_wrap + i, high = num_wrap + i + 1;
            tetrahedra.row(row++) << low, a, b, d;
            tetrahedra.row(row++) << low, b, c, d;
            tetrahedra.row(row++) << low, high, c, b;
        }
    }
    const auto position = [&](int vertex) -> Eigen::Vector3d {
        return (vertex < num_wrap ? wrap.row(vertex) : axis.row(vertex - num_wrap)).transpose();
    };
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        const Eigen::Vector3d origin = position(tetrahedra(t, 0));
        const double volume = (position(tetrahedra(t, 1)) - origin)
                                  .cross(position(tetrahedra(t, 2)) - origin)
                                  .dot(position(tetrahedra(t, 3)) - origin);
        if (volume < 0.0) std::swap(tetrahedra(t, 2), tetrahedra(t, 3));
    }
    return tetrahedra;
}

/// Upper arm below, forearm above, blended over the middle by 3 t^2 - 2 t^3.
SkinningWeights weights_along_tube(const Skeleton& skeleton, const Points& points)
{
    RowMatrix dense = RowMatrix::Zero(points.rows(), skeleton.num_joints());
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double t = std::clamp((points(i, 1) / tube_height - 0.25) / 0.5, 0.0, 1.0);
        const double forearm = t * t * (3.0 - 2.0 * t);
        dense(i, skeleton.joint("left_upper_arm")) = 1.0 - forearm;
        dense(i, skeleton.joint("left_forearm")) = forearm;
    }
    return sparsify_weights(dense);
}

/// The tube is the left arm, pointing up; the other joints stand at distinct places around it, each a little away from
/// its parent.
Points tube_joint_positions(const Skeleton& skeleton)
{
    Points positions(skeleton.num_joints(), 3);
    positions.row(0) << -0.3, -0.5, 0.0;
    for (int j = 1; j < skeleton.num_joints(); ++j) {
        const int parent = skeleton.parents[j];
        positions.row(j) = positions.row(parent) + Eigen::RowVector3d(0.002 * j, 0.08, 0.001 * j);
    }
    positions.row(skeleton.joint("left_upper_arm")) << 0.0, 0.0, 0.0;
    positions.row(skeleton.joint("left_forearm")) << 0.0, 0.5 * tube_height, 0.0;
    positions.row(skeleton.joint("left_forearm_twist")) << 0.0, 0.75 * tube_height, 0.0;
    positions.row(skeleton.joint("left_hand")) << 0.0, tube_height, 0.0;
    const int hand = skeleton.joint("left_hand");
    for (int j = hand + 1; j < hand + 16; ++j) {
        const int finger = (j - hand - 1) / 3, phalanx = (j - hand - 1) % 3;
        positions.row(j) << 0.015 * (finger - 2), tube_height + 0.04 + 0.03 * phalanx, 0.0;
    }
    return positions;
}

/// A slender bone on the axis and a muscle blob between bone wrap and muscle wrap, both closed.
void add_anatomy(Template& tube)
{
    constexpr int rings = 5, segments = 6;
    const Points shaft = closed_cylinder_points(rings, segments, 0.01, 0.1 * tube_height, 0.9 * tube_height);
    Points blob(shaft.rows(), 3);
    for (int i = 0; i < rings * segments; ++i) {
        const double y = 0.9 * (2.0 * (i / segments) / (rings - 1) - 1.0);
        const double angle = 2.0 * pi * (i % segments) / segments;
        blob.row(i) << std::sqrt(1.0 - y * y) * std::cos(angle), y, std::sqrt(1.0 - y * y) * std::sin(angle);
    }
    blob.bottomRows(2) << 0.0, -1.0, 0.0, 0.0, 1.0, 0.0;
    blob = (blob.array().rowwise() * Eigen::Array<double, 1, 3>(0.005, 0.15, 0.005)).matrix();
    blob.rowwise() += Eigen::RowVector3d(0.5 * (bone_radius + muscle_radius), 0.5 * tube_height, 0.0);

    const Triangles triangles = closed_triangles(rings, segments);
    const int num_vertices = static_cast<int>(shaft.rows()), num_triangles = static_cast<int>(triangles.rows());
    tube.anatomy_vertices = append_rows(shaft, blob);
    tube.anatomy_triangles.resize(2 * num_triangles, 3);
    tube.anatomy_triangles << triangles, triangles.array() + num_vertices;
    tube.anatomy_parts = {
        {"shaft", AnatomyLayer::bone, 0, num_vertices, 0, num_triangles},
        {"muscle", AnatomyLayer::muscle, num_vertices, 2 * num_vertices, num_triangles, 2 * num_triangles}};
    tube.embedding = embed_points(tube.anatomy_vertices, tube.rest.volume_vertices, tube.prisms,
                                  tube.rest.interior_vertices, tube.tetrahedra, tube.num_wrap_vertices());
    tube.anatomy_weights =
        embedded_weights(tube.embedding, tube.volume_weights(), tube.interior_weights, tube.skeleton.num_joints());
}

}  // namespace

TemporaryFolder::TemporaryFolder()
{
    std::string pattern = (std::filesystem::temp_directory_path() / "ndg_test_XXXXXX").string();
    require(mkdtemp(pattern.data()) != nullptr, "No temporary folder could be made as {}", pattern);
    path_ = pattern;
}

TemporaryFolder::~TemporaryFolder()
{
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string data_folder()
{
    const char* variable = std::getenv("NDG_DATA");
    std::string folder = variable != nullptr ? variable : "";
    if (folder.empty() || !std::filesystem::is_directory(folder)) {
        std::cout << "Skipped: there is no folder of real data (set NDG_DATA)" << std::endl;
        return "";
    }
    return folder;
}

CommandResult run_command(const std::string& command)
{
    CommandResult result;
    std::FILE* pipe = popen(("( " + command + "\n) 2>&1").c_str(), "r");
    require(pipe != nullptr, "The command could not be started: {}", command);
    std::array<char, 4096> buffer;
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
        result.output.append(buffer.data(), count);
    }
    const int status = pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

std::string tool_path(const std::string& name)
{
    return std::string(NDG_TEST_BIN) + "/" + name;
}

Template tube_template(int rings, int segments)
{
    require(rings >= 3 && segments >= 3, "A tube of {} rings and {} segments is too coarse", rings, segments);
    Template tube;
    tube.skeleton = standard_skeleton();
    tube.rest.name = "tube";
    tube.rest.joint_positions = tube_joint_positions(tube.skeleton);

    const int num_wrap = rings * segments;
    tube.skin_triangles = closed_triangles(rings, segments);
    tube.rest.skin_vertices = closed_cylinder_points(rings, segments, skin_radius, 0.0, tube_height);
    tube.skin_weights = weights_along_tube(tube.skeleton, tube.rest.skin_vertices);
    for (int i = 0; i < num_wrap; ++i) tube.wrap_to_skin.push_back(i);
    tube.wrap_triangles = lateral_triangles(rings, segments);
    tube.prisms = layer_prisms(tube.wrap_triangles, num_wrap);

    const Points bone_wrap = cylinder_points(rings, segments, bone_radius, 0.0, tube_height);
    tube.rest.volume_vertices =
        append_rows(append_rows(bone_wrap, cylinder_points(rings, segments, muscle_radius, 0.0, tube_height)),
                    tube.rest.skin_vertices.topRows(num_wrap));
    tube.rest.interior_vertices.setZero(rings, 3);
    for (int i = 0; i < rings; ++i) tube.rest.interior_vertices(i, 1) = tube_height * i / (rings - 1);
    tube.tetrahedra = axis_tetrahedra(rings, segments, bone_wrap, tube.rest.interior_vertices);
    tube.interior_weights = weights_along_tube(tube.skeleton, tube.rest.interior_vertices);

    add_anatomy(tube);
    tube.source_vertices.resize(0, 3);
    tube.source_barycentric.resize(0, 3);
    return tube;
}

Template symmetric_tube_template(int rings)
{
    constexpr int segments = 8;
    Template tube = tube_template(rings, segments);
    const Skeleton& skeleton = tube.skeleton;
    Points& joints = tube.rest.joint_positions;
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[j];
        if (name.rfind("left_", 0) == 0)
            joints.row(skeleton.joint("right_" + name.substr(5))) =
                joints.row(j).cwiseProduct(Eigen::RowVector3d(-1, 1, 1));
        else if (name.rfind("right_", 0) != 0)
            joints(j, 0) = 0;
    }
    const auto smooth = [](double t) { return t = std::clamp(t, 0.0, 1.0), t * t * (3.0 - 2.0 * t); };
    RowMatrix dense = RowMatrix::Zero(tube.rest.skin_vertices.rows(), skeleton.num_joints());
    for (Eigen::Index i = 0; i < dense.rows(); ++i) {
        const double t = tube.rest.skin_vertices(i, 1) / tube_height;
        const double arm = smooth((t - 0.2) / 0.3), forearm = smooth((t - 0.6) / 0.3);
        const double left = smooth(0.5 + 0.5 * tube.rest.skin_vertices(i, 0) / skin_radius);
        dense(i, skeleton.joint("spine_2")) = 1.0 - arm;
        for (const auto& [side, share] : {std::pair("left", left), std::pair("right", 1.0 - left)}) {
            dense(i, skeleton.joint(side + std::string("_upper_arm"))) = arm * share * (1.0 - forearm);
            dense(i, skeleton.joint(side + std::string("_forearm"))) = arm * share * forearm;
        }
    }
    tube.skin_weights = sparsify_weights(dense);
    for (const char* side : {"left", "right"}) {
        const double x = side == std::string("left") ? 0.02 : -0.02;
        joints.row(skeleton.joint(side + std::string("_upper_arm"))) << x, 0.35 * tube_height, 0;
        joints.row(skeleton.joint(side + std::string("_forearm"))) << x, 0.75 * tube_height, 0;
    }
    joints.row(skeleton.joint("spine_2")) << 0, 0.1 * tube_height, 0;
    joints.row(skeleton.joint("spine_3")) << 0, 0.3 * tube_height, 0;

    // The diagonals of the half x < 0 are those of the other half, mirrored: segment s lies opposite 4 - s.
    Triangles& triangles = tube.wrap_triangles;
    Eigen::Index row = 0;
    const auto mirrored = [](int v) { return v / segments * segments + (segments + 4 - v % segments) % segments; };
    Triangles symmetric(triangles.rows(), 3);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        double x = 0;
        for (int k = 0; k < 3; ++k) x += tube.rest.skin_vertices(triangles(t, k), 0);
        if (x < 0) continue;
        symmetric.row(row++) = triangles.row(t);
        symmetric.row(row++) << mirrored(triangles(t, 0)), mirrored(triangles(t, 2)), mirrored(triangles(t, 1));
    }
    triangles = symmetric;
    tube.prisms = layer_prisms(triangles, tube.num_wrap_vertices());
    return tube;
}

Pose tube_pose(double angle)
{
    const Skeleton& skeleton = standard_skeleton();
    Pose pose = Pose::rest(skeleton.num_joints());
    pose.parent_from_joint[skeleton.joint("left_forearm")] =
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    return pose;
}

}  // namespace ndg::test
