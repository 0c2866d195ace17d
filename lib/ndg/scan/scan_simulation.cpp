// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan_simulation.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/scan/retriangulate.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace ndg {
namespace {

Eigen::Vector3d random_direction(Random& random)
{
    Eigen::Vector3d direction;
    do {
        direction = {random.normal(), random.normal(), random.normal()};
    } while (direction.norm() < 1e-6);
    return direction.normalized();
}

/// Shoulders and hips turn about any axis; elbows and knees bend, elbows forward and knees backward.
Pose random_pose(const Points& joints, double degrees, Random& random)
{
    const Skeleton& skeleton = standard_skeleton();
    Pose pose = Pose::rest(skeleton.num_joints());
    const double limit = degrees * EIGEN_PI / 180.0;
    const auto turn = [&](const std::string& joint, const Eigen::Vector3d& axis) {
        pose.parent_from_joint[skeleton.joint(joint)] =
            Eigen::AngleAxisd(limit * random.uniform(), axis).toRotationMatrix();
    };
    for (const std::string side : {"left_", "right_"}) {
        turn(side + "upper_arm", random_direction(random));
        const Eigen::Vector3d forearm =
            (joints.row(skeleton.joint(side + "hand")) - joints.row(skeleton.joint(side + "forearm"))).transpose();
        turn(side + "forearm", forearm.cross(Eigen::Vector3d::UnitZ()).normalized());
        turn(side + "thigh", random_direction(random));
        turn(side + "shin", Eigen::Vector3d::UnitX());
    }
    return pose;
}

/// N values, 1 at skin vertices that the scanner does not see.
Eigen::VectorXd unseen_vertices(const SkinnedSurface& skin, double radius, Random& random)
{
    Eigen::VectorXd unseen = Eigen::VectorXd::Zero(skin.vertices.rows());
    if (radius <= 0) return unseen;
    const SkinPlaces places = find_skin_places(skin);
    for (const Eigen::Vector3d& centre : {places.left_armpit, places.right_armpit, places.crotch}) {
        const double reach = radius * random.uniform(0.8, 1.2);
        for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
            if ((skin.vertices.row(v).transpose() - centre).norm() < reach) unseen[v] = 1.0;
        }
    }
    const double head = places.head_top - 0.6 * radius * random.uniform(0.5, 1.2);
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        if (skin.vertices(v, 1) > head) unseen[v] = 1.0;
    }
    for (const int v : places.sole_vertices) unseen[v] = 1.0;
    return unseen;
}

/// Takes away triangles with an unseen vertex, and vertices without a triangle.
void cut_holes(const Eigen::VectorXd& unseen, Points& vertices, Points& normals, Triangles& triangles)
{
    std::vector<int> new_of_old(vertices.rows(), -1);
    Eigen::Index num_triangles = 0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const bool seen =
            unseen[triangles(t, 0)] < 0.5 && unseen[triangles(t, 1)] < 0.5 && unseen[triangles(t, 2)] < 0.5;
        if (seen) triangles.row(num_triangles++) = triangles.row(t);
    }
    triangles.conservativeResize(num_triangles, 3);
    for (Eigen::Index i = 0; i < triangles.size(); ++i) {
        new_of_old[triangles.data()[i]] = 0;
    }
    Eigen::Index num_vertices = 0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        int& index = new_of_old[v];
        if (index < 0) continue;
        index = static_cast<int>(num_vertices);
        vertices.row(num_vertices) = vertices.row(v);
        normals.row(num_vertices++) = normals.row(v);
    }
    vertices.conservativeResize(num_vertices, 3);
    normals.conservativeResize(num_vertices, 3);
    for (Eigen::Index i = 0; i < triangles.size(); ++i) {
        triangles.data()[i] = new_of_old[triangles.data()[i]];
    }
}

/// The order of a file's vertices tells a point cloud's reader nothing.
void shuffle(Points& vertices, Points& normals, Random& random)
{
    const std::vector<int> order = random.permutation(static_cast<int>(vertices.rows()));
    const Points old_vertices = vertices, old_normals = normals;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        vertices.row(v) = old_vertices.row(order[v]);
        normals.row(v) = old_normals.row(order[v]);
    }
}

}  // namespace

void describe(OptionList& list, ScanSimulationOptions& options)
{
    list.add("points", options.points, "points of a scan, about", 2000, 5000000);
    list.add("noise", options.noise, "standard deviation of the noise along the normal, m", 0, 0.02);
    list.add("pose-angle", options.pose_angle, "shoulders, elbows, hips and knees turn by up to this, degrees", 0, 30);
    list.add("hole-radius", options.hole_radius, "of the holes at armpits and crotch, m; 0: no holes at all", 0, 0.2);
    list.add("cloud", options.cloud, "points without triangles");
    list.add("place", options.place, "random heading and position");
    list.add("fault", options.fault, "what makes the scan a difficult one");
}

SimulatedScan simulate_scan(const SkinnedSurface& given, const ScanSimulationOptions& options, std::uint64_t seed,
                            int body_idx)
{
    check_options(options);
    const auto index = static_cast<std::uint64_t>(body_idx);
    Random pose_random(seed, "scan pose", index), place_random(seed, "scan place", index);
    Random mesh_random(seed, "scan mesh", index), noise_random(seed, "scan noise", index);

    SimulatedScan result;
    result.person = person_of_fault(options.fault, given);
    const SkinnedSurface& skin = result.person;
    result.pose = random_pose(skin.joint_positions, options.pose_angle, pose_random);
    add_fault_pose(options.fault, skin.joint_positions, result.pose);
    if (options.place) {
        result.pose.parent_from_joint[0] = about_y(place_random.uniform(0.0, 2.0 * EIGEN_PI));
        for (int k = 0; k < 3; ++k) result.pose.root_translation[k] = place_random.uniform(-0.5, 0.5);
    }
    const auto world_from_rest = forward_kinematics(standard_skeleton(), skin.joint_positions, result.pose);
    result.posed_skin = linear_blend_skinning(skin.vertices, skin.weights, world_from_rest);
    result.posed_joints.resize(skin.joint_positions.rows(), 3);
    for (std::size_t j = 0; j < world_from_rest.size(); ++j) {
        const auto row = static_cast<Eigen::Index>(j);
        result.posed_joints.row(row) = (world_from_rest[j] * skin.joint_positions.row(row).transpose()).transpose();
    }

    RowMatrix attributes(skin.vertices.rows(), 4);
    attributes.leftCols(3) = surface_of_fault(options.fault, skin, result.posed_skin, result.covered);
    attributes.col(3) = unseen_vertices(skin, options.hole_radius, mesh_random);
    Triangles triangles = skin.triangles;
    if (options.fault != ScanFault::large_triangles) {
        retriangulate(attributes, triangles, options.points, mesh_random);
    }
    Points vertices = attributes.leftCols(3);
    Points normals = vertex_normals(vertices, triangles);
    cut_holes(attributes.col(3), vertices, normals, triangles);
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        vertices.row(v) += options.noise * noise_random.normal() * normals.row(v);
    }
    if (options.fault != ScanFault::none) {
        apply_fault_to_mesh(options.fault, skin, result.posed_skin, vertices, triangles);
        normals = vertex_normals(vertices, triangles);
        if (options.fault == ScanFault::mirrored) {
            result.posed_skin.col(0) *= -1.0;
            result.posed_joints.col(0) *= -1.0;
        }
    }
    if (options.cloud) {
        shuffle(vertices, normals, mesh_random);
        triangles.resize(0, 3);
    }
    result.scan = {std::move(vertices), std::move(triangles), std::move(normals)};
    return result;
}

}  // namespace ndg
