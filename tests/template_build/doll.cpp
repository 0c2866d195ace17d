// SPDX-License-Identifier: Apache-2.0
#include "template_build/doll.h"

#include "ndg/body/skeleton.h"
#include "ndg/geometry/isosurface.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace ndg::test {
namespace {

struct Bone {
    std::string joint;  ///< its motion
    Eigen::Vector3d begin, end;
    double radius;
};

/// The left half and the midline.
std::vector<Bone> left_bones()
{
    return {{"pelvis", {0, 0.95, 0}, {0, 1.02, 0}, 0.13},
            {"spine_1", {0, 1.02, 0}, {0, 1.09, 0}, 0.12},
            {"spine_2", {0, 1.09, 0}, {0, 1.16, 0}, 0.12},
            {"spine_3", {0, 1.16, 0}, {0, 1.22, 0}, 0.12},
            {"spine_4", {0, 1.22, 0}, {0, 1.28, 0}, 0.12},
            {"spine_5", {0, 1.28, 0}, {0, 1.36, 0}, 0.09},
            {"neck_1", {0, 1.40, 0}, {0, 1.45, 0}, 0.055},
            {"neck_2", {0, 1.45, 0}, {0, 1.50, 0}, 0.055},
            {"head", {0, 1.50, 0}, {0, 1.62, 0}, 0.09},
            {"left_clavicle", {0.03, 1.34, 0}, {0.18, 1.34, 0}, 0.06},
            {"left_upper_arm", {0.18, 1.34, 0}, {0.37, 1.12, 0}, 0.045},
            {"left_forearm", {0.37, 1.12, 0}, {0.45, 1.02, 0}, 0.035},
            {"left_forearm_twist", {0.45, 1.02, 0}, {0.52, 0.93, 0}, 0.03},
            {"left_hand", {0.52, 0.93, 0}, {0.57, 0.86, 0}, 0.035},
            {"left_middle_1", {0.57, 0.86, 0}, {0.60, 0.82, 0}, 0.025},
            {"left_thigh", {0.10, 0.92, 0}, {0.12, 0.50, 0}, 0.07},
            {"left_shin", {0.12, 0.50, 0}, {0.13, 0.09, 0}, 0.045},
            {"left_foot", {0.13, 0.05, -0.02}, {0.14, 0.045, 0.09}, 0.042},
            {"left_toes", {0.14, 0.045, 0.09}, {0.145, 0.04, 0.14}, 0.035}};
}

double distance_to(const Bone& bone, const Eigen::Vector3d& point)
{
    const Eigen::Vector3d along = bone.end - bone.begin;
    const double t = std::clamp((point - bone.begin).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (point - bone.begin - t * along).norm() - bone.radius;
}

std::vector<double> axis(double low, double high, double cell)
{
    std::vector<double> planes;
    const int count = static_cast<int>(std::ceil((high - low) / cell));
    for (int i = 0; i <= count; ++i) planes.push_back(low + (high - low) * i / count);
    return planes;
}

Points joints()
{
    const Skeleton& skeleton = standard_skeleton();
    Points positions = Points::Zero(skeleton.num_joints(), 3);
    const auto set = [&](const std::string& name, const Eigen::Vector3d& place) {
        positions.row(skeleton.joint(name)) = place.transpose();
        if (name.rfind("left_", 0) == 0)
            positions.row(skeleton.joint("right_" + name.substr(5))) << -place[0], place[1], place[2];
    };
    for (const Bone& bone : left_bones()) set(bone.joint, bone.begin);
    set("jaw", {0, 1.53, 0.03});
    set("left_eye", {0.03, 1.62, 0.06});
    set("left_foot", {0.13, 0.09, 0});
    const Eigen::Vector3d hand(0.57, 0.86, 0), finger(0.012, -0.016, 0);
    double across = 0.02;
    for (const std::string name : {"thumb", "index", "middle", "ring", "pinky"}) {
        for (int k = 0; k < 3; ++k)
            set("left_" + name + "_" + std::to_string(k + 1), hand + k * finger + Eigen::Vector3d(0, 0, across));
        across -= 0.01;
    }
    return positions;
}

}  // namespace

Doll make_doll(double cell)
{
    std::vector<Bone> bones = left_bones();
    for (const Bone& bone : left_bones()) {
        if (bone.joint.rfind("left_", 0) != 0) continue;
        const Eigen::Vector3d mirror(-1, 1, 1);
        bones.push_back({"right_" + bone.joint.substr(5), bone.begin.cwiseProduct(mirror),
                         bone.end.cwiseProduct(mirror), bone.radius});
    }
    constexpr double blend = 0.012;  // m, rounds the joins
    const auto field = [&](const Eigen::Vector3d& point) {
        double sum = 0.0;
        for (const Bone& bone : bones) sum += std::exp(-distance_to(bone, point) / blend);
        return -blend * std::log(std::max(sum, 1e-300));
    };
    // The left half, which ends in a border on x = 0, and its mirror image.
    const TriangleMesh half =
        marching_tetrahedra(field, {axis(0.0, 0.7, cell), axis(-0.05, 1.8, cell), axis(-0.2, 0.25, cell)});
    std::vector<int> right_of_left(half.vertices.rows(), -1);
    for (const auto& loop : boundary_loops(half.triangles, static_cast<int>(half.vertices.rows())))
        for (const int v : loop) right_of_left[v] = v;
    Doll doll;
    Points& vertices = doll.surface.vertices;
    vertices.resize(2 * half.vertices.rows(), 3);
    vertices.topRows(half.vertices.rows()) = half.vertices;
    Eigen::Index count = half.vertices.rows();
    for (Eigen::Index v = 0; v < half.vertices.rows(); ++v) {
        int& right = right_of_left[v];
        if (right >= 0) {
            vertices(v, 0) = 0.0;
            continue;
        }
        right = static_cast<int>(count);
        vertices.row(count++) << -half.vertices(v, 0), half.vertices(v, 1), half.vertices(v, 2);
    }
    vertices.conservativeResize(count, 3);
    doll.surface.triangles.resize(2 * half.triangles.rows(), 3);
    doll.surface.triangles.topRows(half.triangles.rows()) = half.triangles;
    for (Eigen::Index t = 0; t < half.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k)
            doll.surface.triangles(half.triangles.rows() + t, k) = right_of_left[half.triangles(t, 2 - k)];
    doll.surface.joint_positions = joints();
    const double floor = vertices.col(1).minCoeff();
    const Skeleton& skeleton = standard_skeleton();
    doll.weights.setZero(vertices.rows(), skeleton.num_joints());
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        for (const Bone& bone : bones)
            doll.weights(v, skeleton.joint(bone.joint)) +=
                std::exp(-distance_to(bone, vertices.row(v).transpose()) / 0.01);
        doll.weights.row(v) /= doll.weights.row(v).sum();
    }
    doll.surface.vertices.col(1).array() -= floor;
    doll.surface.joint_positions.col(1).array() -= floor;
    return doll;
}

}  // namespace ndg::test
