// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan_fault.h"

#include "ndg/core/error.h"
#include "ndg/geometry/decimate.h"
#include "ndg/geometry/point_tree.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace ndg {
namespace {

constexpr double radian = EIGEN_PI / 180.0;
/// Share of an arm's elevation that the clavicle takes, which moves the shoulder joint: between 45 and 120 degrees the
/// joint's centre rises by some 2.8 cm (from the bone-pin means of Ludewig et al. 2009), 15 cm beside the clavicle's.
constexpr double clavicle_share = 0.15;

Eigen::Vector3d joint_at(const Eigen::Ref<const Points>& joints, const std::string& name)
{
    return joints.row(standard_skeleton().joint(name)).transpose();
}

void point_arm(const std::string& side, const Eigen::Vector3d& direction, const Eigen::Ref<const Points>& joints,
               Pose& pose)
{
    const Skeleton& skeleton = standard_skeleton();
    const Eigen::Vector3d bone =
        (joint_at(joints, side + "forearm") - joint_at(joints, side + "upper_arm")).normalized();
    const Eigen::AngleAxisd turn(minimal_rotation(bone, direction.normalized()));
    const auto part = [&](double share) {
        return Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
    };
    pose.parent_from_joint[skeleton.joint(side + "clavicle")] = part(clavicle_share);
    pose.parent_from_joint[skeleton.joint(side + "upper_arm")] = part(1.0 - clavicle_share);
}

void close_hand(const std::string& side, const Eigen::Ref<const Points>& joints, Pose& pose)
{
    const Eigen::Vector3d hand = joint_at(joints, side + "hand");
    Eigen::Vector3d palm =
        (joint_at(joints, side + "index_1") - hand).cross(joint_at(joints, side + "pinky_1") - hand).normalized();
    if (palm.dot(joint_at(joints, side + "thumb_3") - hand) < 0) palm *= -1.0;
    for (const char* finger : {"index", "middle", "ring", "pinky"}) {
        const std::string name = side + finger + "_";
        const Eigen::Vector3d along = joint_at(joints, name + "2") - joint_at(joints, name + "1");
        const Eigen::Vector3d axis = along.cross(palm).normalized();
        const double degrees[] = {75.0, 85.0, 50.0};
        for (int k = 0; k < 3; ++k) {
            pose.parent_from_joint[standard_skeleton().joint(name + std::to_string(k + 1))] =
                Eigen::AngleAxisd(degrees[k] * radian, axis).toRotationMatrix();
        }
    }
}

/// 0 below `low`, 1 above `high`, smooth between.
double ramp(double value, double low, double high)
{
    const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// Trousers from the waist to above the ankles, wider and with folds further down; their lower end is a step.
void put_on_trousers(const SkinnedSurface& rest, Points& surface, std::vector<char>& covered)
{
    const Points normals = vertex_normals(surface, rest.triangles);
    const Eigen::VectorXd legs = subtree_weights(rest.weights, {"left_thigh", "right_thigh"});
    const Eigen::VectorXd feet = subtree_weights(rest.weights, {"left_foot", "right_foot"});
    const Eigen::VectorXd trunk = subtree_weights(rest.weights, {"spine_3"});
    const Eigen::VectorXd hands = subtree_weights(rest.weights, {"left_clavicle", "right_clavicle"});
    const double ankle = joint_at(rest.joint_positions, "left_foot")[1];
    const double waist = joint_at(rest.joint_positions, "pelvis")[1] + 0.08;
    const double knee = joint_at(rest.joint_positions, "left_shin")[1];
    for (Eigen::Index v = 0; v < surface.rows(); ++v) {
        const double height = rest.vertices(v, 1);
        if (height < ankle + 0.05 || height > waist || feet[v] > 0.5 || hands[v] > 0.1) continue;
        if (legs[v] < 0.2 && trunk[v] > 0.3) continue;
        const double low = ramp(waist - height, 0.0, waist - knee);
        const double folds = 0.004 * std::sin(140.0 * height + 4.0 * std::sin(30.0 * rest.vertices(v, 0)));
        surface.row(v) += (0.008 + 0.012 * low + low * folds) * normals.row(v);
        covered[v] = 1;
    }
}

/// Shoes: the toes are smoothed away, 7 mm of upper, 22 mm of sole.
void put_on_shoes(const SkinnedSurface& rest, Points& surface, std::vector<char>& covered)
{
    const Eigen::VectorXd feet = subtree_weights(rest.weights, {"left_foot", "right_foot"});
    const double ankle = joint_at(rest.joint_positions, "left_foot")[1];
    std::vector<char> shoe(surface.rows(), 0);
    for (Eigen::Index v = 0; v < surface.rows(); ++v) shoe[v] = feet[v] > 0.5 && rest.vertices(v, 1) < ankle + 0.01;
    const auto neighbours = vertex_neighbours(rest.triangles, static_cast<int>(surface.rows()));
    // Rounds that smooth over 8 mm, whatever the edges' length.
    double edge = 0.0, count = 0.0;
    for (Eigen::Index v = 0; v < surface.rows(); ++v) {
        if (!shoe[v]) continue;
        edge += (surface.row(neighbours[v].front()) - surface.row(v)).norm();
        count += 1.0;
    }
    const int rounds = std::clamp(static_cast<int>(2.0 * std::pow(0.008 * count / std::max(edge, 1e-12), 2)), 1, 60);
    for (int round = 0; round < rounds; ++round) {
        const Points old = surface;
        for (Eigen::Index v = 0; v < surface.rows(); ++v) {
            if (!shoe[v]) continue;
            Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
            for (const int other : neighbours[v]) mean += old.row(other) / static_cast<double>(neighbours[v].size());
            surface.row(v) = 0.5 * (old.row(v) + mean);
        }
    }
    const Points normals = vertex_normals(surface, rest.triangles);
    const double floor = rest.vertices.col(1).minCoeff();
    for (Eigen::Index v = 0; v < surface.rows(); ++v) {
        if (!shoe[v]) continue;
        // Smoothing has shrunk the foot; the upper lies around the foot it had.
        surface.row(v) += 0.012 * normals.row(v);
        surface(v, 1) -= 0.022 * ramp(floor + 0.03 - rest.vertices(v, 1), 0.0, 0.02);
        covered[v] = 1;
    }
}

void grow_hair(const SkinnedSurface& rest, Points& surface, std::vector<char>& covered)
{
    const Points normals = vertex_normals(surface, rest.triangles);
    const Eigen::VectorXd head = subtree_weights(rest.weights, {"head"});
    const Eigen::Vector3d eye =
        0.5 * (joint_at(rest.joint_positions, "left_eye") + joint_at(rest.joint_positions, "right_eye"));
    for (Eigen::Index v = 0; v < surface.rows(); ++v) {
        const double above = rest.vertices(v, 1) - eye[1], behind = eye[2] - rest.vertices(v, 2);
        // From the forehead's upper end back and down to the nape.
        const double share = head[v] * ramp(above + 0.9 * (behind - 0.06), 0.045, 0.075);
        if (share < 0.05) continue;
        surface.row(v) += share * (0.03 + 0.004 * std::sin(90.0 * rest.vertices(v, 0))) * normals.row(v);
        covered[v] = 1;
    }
}

/// Triangles of which `label` gives a negative number go, those of equal labels become one shell, with vertices of its
/// own.
template <typename Label>
void split_by(const Label& label, Points& vertices, Triangles& triangles)
{
    std::vector<std::vector<int>> shells;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const int wanted = label(t);
        if (wanted < 0) continue;
        if (wanted >= static_cast<int>(shells.size())) shells.resize(static_cast<std::size_t>(wanted) + 1);
        shells[wanted].push_back(static_cast<int>(t));
    }
    std::vector<TriangleMesh> meshes;
    for (const std::vector<int>& shell : shells) {
        TriangleMesh mesh;
        mesh.triangles.resize(static_cast<Eigen::Index>(shell.size()), 3);
        std::vector<int> new_of_old(vertices.rows(), -1);
        std::vector<int> used;
        for (std::size_t i = 0; i < shell.size(); ++i) {
            for (int k = 0; k < 3; ++k) {
                const int v = triangles(shell[i], k);
                if (new_of_old[v] < 0) {
                    new_of_old[v] = static_cast<int>(used.size());
                    used.push_back(v);
                }
                mesh.triangles(static_cast<Eigen::Index>(i), k) = new_of_old[v];
            }
        }
        mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
        for (std::size_t i = 0; i < used.size(); ++i) {
            mesh.vertices.row(static_cast<Eigen::Index>(i)) = vertices.row(used[i]);
        }
        meshes.push_back(std::move(mesh));
    }
    TriangleMesh all = join_meshes(meshes);
    vertices = std::move(all.vertices);
    triangles = std::move(all.triangles);
}

void cut_into_pieces(const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed_skin, Points& vertices,
                     Triangles& triangles)
{
    const std::vector<std::vector<std::string>> roots = {
        {"left_upper_arm"}, {"right_upper_arm"}, {"head"}, {"left_thigh"}, {"right_thigh"}};
    std::vector<Eigen::VectorXd> shares;
    for (const auto& root : roots) shares.push_back(subtree_weights(rest.weights, root));
    const Points normals = vertex_normals(rest.vertices, rest.triangles);
    std::vector<int> label_of_vertex(rest.vertices.rows());
    const int trunk = static_cast<int>(roots.size());
    for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
        label_of_vertex[v] = normals(v, 2) > 0 ? trunk : trunk + 1;
        for (int part = 0; part < trunk; ++part) {
            if (shares[part][v] > 0.5) label_of_vertex[v] = part;
        }
    }
    const PointTree tree(posed_skin);
    std::vector<int> labels(vertices.rows());
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        labels[v] = label_of_vertex[tree.nearest(vertices.row(v).transpose()).idx];
    }
    // What lies between two shells is in neither.
    const Triangles given = triangles;
    const auto label = [&](Eigen::Index t) {
        const int a = labels[given(t, 0)];
        return a == labels[given(t, 1)] && a == labels[given(t, 2)] ? a : -1;
    };
    split_by(label, vertices, triangles);
    // The shells of the arms come first.
    Eigen::Index num_arm_triangles = 0;
    for (Eigen::Index t = 0; t < given.rows(); ++t) num_arm_triangles += label(t) == 0 || label(t) == 1;
    triangles.topRows(num_arm_triangles).col(1).swap(triangles.topRows(num_arm_triangles).col(2));
}

/// A floor of 1.8 m, a little uneven, and a box beside the person.
void add_floor(Points& vertices, Triangles& triangles)
{
    constexpr int cells = 90;
    constexpr double cell = 0.02;
    const Eigen::RowVector3d low(vertices.col(0).mean() - 0.5 * cells * cell, vertices.col(1).minCoeff(),
                                 vertices.col(2).mean() - 0.5 * cells * cell);
    TriangleMesh floor, box;
    floor.vertices.resize((cells + 1) * (cells + 1), 3);
    floor.triangles.resize(2 * cells * cells, 3);
    for (int i = 0; i <= cells; ++i) {
        for (int k = 0; k <= cells; ++k) {
            floor.vertices.row(i * (cells + 1) + k) =
                low + Eigen::RowVector3d(cell * i, 0.0015 * std::sin(3.0 * i) * std::cos(2.0 * k), cell * k);
        }
    }
    for (int i = 0; i < cells; ++i) {
        for (int k = 0; k < cells; ++k) {
            const int corner = i * (cells + 1) + k;
            floor.triangles.row(2 * (i * cells + k)) << corner, corner + 1, corner + cells + 1;
            floor.triangles.row(2 * (i * cells + k) + 1) << corner + 1, corner + cells + 2, corner + cells + 1;
        }
    }
    box.vertices.resize(8, 3);
    for (int c = 0; c < 8; ++c) {
        box.vertices.row(c) =
            low + Eigen::RowVector3d(0.05 + 0.2 * (c & 1), 0.02 + 0.3 * (c >> 1 & 1), 0.05 + 0.2 * (c >> 2 & 1));
    }
    box.triangles.resize(12, 3);
    box.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5,
        3, 7, 5;
    TriangleMesh all = join_meshes(std::vector<TriangleMesh>{{vertices, triangles}, floor, box});
    vertices = std::move(all.vertices);
    triangles = std::move(all.triangles);
}

}  // namespace

SkinnedSurface person_of_fault(ScanFault fault, SkinnedSurface skin)
{
    if (fault != ScanFault::child) return skin;
    // A child of 1.2 m has a head of 0.16 of its stature, an adult of 0.13.
    constexpr double size = 0.7, head_size = 1.3;
    const Eigen::VectorXd head = subtree_weights(skin.weights, {"head"});
    const Eigen::RowVector3d neck = joint_at(skin.joint_positions, "head").transpose();
    const auto grow = [&](Eigen::Ref<Eigen::RowVector3d> place, double share) {
        place += share * (head_size - 1.0) * (place - neck);
        place *= size;
    };
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        Eigen::RowVector3d place = skin.vertices.row(v);
        grow(place, head[v]);
        skin.vertices.row(v) = place;
    }
    for (const char* name : {"jaw", "left_eye", "right_eye"}) {
        const int joint = standard_skeleton().joint(name);
        skin.joint_positions.row(joint) += (head_size - 1.0) * (skin.joint_positions.row(joint) - neck);
    }
    skin.joint_positions *= size;
    return skin;
}

void add_fault_pose(ScanFault fault, const Eigen::Ref<const Points>& joints, Pose& pose)
{
    for (const double x : {1.0, -1.0}) {
        const std::string side = x > 0 ? "left_" : "right_";
        if (fault == ScanFault::t_pose) point_arm(side, {x, 0.0, 0.0}, joints, pose);
        if (fault == ScanFault::arms_raised) point_arm(side, {0.7 * x, 0.7, 0.1}, joints, pose);
        if (fault == ScanFault::fists) close_hand(side, joints, pose);
    }
}

Points surface_of_fault(ScanFault fault, const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed_skin,
                        std::vector<char>& covered)
{
    Points surface = posed_skin;
    covered.assign(surface.rows(), 0);
    if (fault == ScanFault::clothes) {
        put_on_trousers(rest, surface, covered);
        put_on_shoes(rest, surface, covered);
    }
    if (fault == ScanFault::hair) grow_hair(rest, surface, covered);
    return surface;
}

void apply_fault_to_mesh(ScanFault fault, const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed_skin,
                         Points& vertices, Triangles& triangles)
{
    if (fault == ScanFault::pieces) cut_into_pieces(rest, posed_skin, vertices, triangles);
    if (fault == ScanFault::floor) add_floor(vertices, triangles);
    if (fault == ScanFault::mirrored) vertices.col(0) *= -1.0;
    if (fault == ScanFault::large_triangles) {
        const TriangleMesh mesh = {vertices, triangles};
        LabelledMesh coarse = decimate_labelled(mesh, std::vector<int>(triangles.rows(), 1), 3000);
        vertices = std::move(coarse.mesh.vertices);
        triangles = std::move(coarse.mesh.triangles);
    }
    if (fault == ScanFault::no_feet) {
        const Eigen::VectorXd feet = subtree_weights(rest.weights, {"left_foot", "right_foot"});
        const PointTree tree(posed_skin);
        const Triangles given = triangles;
        const Points places = vertices;
        split_by(
            [&](Eigen::Index t) { return feet[tree.nearest(places.row(given(t, 0)).transpose()).idx] > 0.5 ? -1 : 0; },
            vertices, triangles);
    }
}

}  // namespace ndg
