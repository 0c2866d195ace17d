// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/bone_shafts.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr int segments_around = 12;
constexpr int rings_per_shaft = 14;
constexpr double share_of_room = 0.8;

struct Shaft {
    std::string name;
    std::vector<std::string> joints;  ///< the axis runs through these
    double radius;                    ///< of the shaft's middle, m
    double end_swelling;              ///< how much thicker the ends are
    double begin, end;                ///< part of the axis that is bone
};

/// Mid-shaft radii of an adult in round figures; paired bones of forearm and lower leg count as one.
std::vector<Shaft> shafts()
{
    std::vector<Shaft> list = {
        {"spine", {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5", "neck_1"}, 0.020, 0.0, 0.03, 0.97}};
    for (const std::string side : {"left", "right"}) {
        const auto with_side = [&](const char* joint) { return side + "_" + joint; };
        list.push_back({side + " clavicle", {with_side("clavicle"), with_side("upper_arm")}, 0.007, 0.3, 0.1, 0.85});
        list.push_back({side + " humerus", {with_side("upper_arm"), with_side("forearm")}, 0.011, 0.7, 0.03, 0.97});
        list.push_back({side + " radius and ulna",
                        {with_side("forearm"), with_side("forearm_twist"), with_side("hand")},
                        0.011,
                        0.4,
                        0.03,
                        0.90});
        list.push_back({side + " femur", {with_side("thigh"), with_side("shin")}, 0.014, 0.8, 0.02, 0.97});
        list.push_back({side + " tibia and fibula", {with_side("shin"), with_side("foot")}, 0.014, 0.7, 0.03, 0.97});
    }
    return list;
}

/// Point and unit tangent at parameter t in [0, 1] of the length of a polyline.
void polyline_at(const std::vector<Eigen::Vector3d>& nodes, double t, Eigen::Vector3d& point, Eigen::Vector3d& tangent)
{
    double total = 0.0;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) total += (nodes[i + 1] - nodes[i]).norm();
    double rest = t * total;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
        const Eigen::Vector3d edge = nodes[i + 1] - nodes[i];
        if (rest <= edge.norm() || i + 2 == nodes.size()) {
            tangent = edge.normalized();
            point = nodes[i] + rest * tangent;
            return;
        }
        rest -= edge.norm();
    }
}

/// The longest stretch of [shaft.begin, shaft.end] around its middle whose points lie inside the bone wrap with room
/// for a thin bone.
void clip_to_inside(Shaft& shaft, const std::vector<Eigen::Vector3d>& nodes, const ClosedBoneWrap& bone_wrap,
                    const TriangleTree& tree)
{
    constexpr int samples = 101;
    constexpr double min_room = 0.003;
    Points points(samples, 3);
    Eigen::Vector3d point, tangent;
    for (int i = 0; i < samples; ++i) {
        polyline_at(nodes, shaft.begin + (shaft.end - shaft.begin) * i / (samples - 1), point, tangent);
        points.row(i) = point.transpose();
    }
    const Eigen::VectorXd winding = winding_numbers(bone_wrap.vertices, bone_wrap.triangles, points);
    const auto inside = [&](int i) {
        return winding[i] > 0.5 && tree.closest(points.row(i).transpose()).distance > min_room;
    };
    const int middle = samples / 2;
    require(inside(middle), "the middle of the {} lies outside the bone wrap", shaft.name);
    int first = middle, last = middle;
    while (first > 0 && inside(first - 1)) --first;
    while (last + 1 < samples && inside(last + 1)) ++last;
    const double length = shaft.end - shaft.begin;
    shaft.end = shaft.begin + length * last / (samples - 1);
    shaft.begin += length * first / (samples - 1);
}

}  // namespace

Anatomy make_bone_shafts(const Eigen::Ref<const Points>& joint_positions, const ClosedBoneWrap& bone_wrap)
{
    const TriangleTree tree(bone_wrap.vertices, bone_wrap.triangles);
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Shaft> list = shafts();
    const int vertices_per_shaft = rings_per_shaft * segments_around + 2;
    const int triangles_per_shaft = 2 * segments_around * rings_per_shaft;
    Anatomy anatomy;
    anatomy.vertices.resize(static_cast<Eigen::Index>(list.size()) * vertices_per_shaft, 3);
    anatomy.triangles.resize(static_cast<Eigen::Index>(list.size()) * triangles_per_shaft, 3);
    int vertex = 0, triangle = 0;
    for (Shaft& shaft : list) {
        const int first = vertex, first_triangle = triangle;
        std::vector<Eigen::Vector3d> nodes;
        for (const auto& joint : shaft.joints)
            nodes.emplace_back(joint_positions.row(skeleton.joint(joint)).transpose());
        clip_to_inside(shaft, nodes, bone_wrap, tree);
        const Eigen::Vector3d axis = (nodes.back() - nodes.front()).normalized();
        const Eigen::Vector3d across = axis.unitOrthogonal();
        Eigen::Vector3d point, tangent;
        for (int r = 0; r < rings_per_shaft; ++r) {
            const double s = static_cast<double>(r) / (rings_per_shaft - 1);
            polyline_at(nodes, shaft.begin + s * (shaft.end - shaft.begin), point, tangent);
            const double towards_end = std::pow(std::abs(2.0 * s - 1.0), 3.0);
            const double round_off = (r == 0 || r == rings_per_shaft - 1) ? 0.6 : 1.0;
            const double radius = round_off * std::min(shaft.radius * (1.0 + shaft.end_swelling * towards_end),
                                                       share_of_room * tree.closest(point).distance);
            const Eigen::Vector3d u = (across - across.dot(tangent) * tangent).normalized(), w = tangent.cross(u);
            for (int k = 0; k < segments_around; ++k) {
                const double angle = 2.0 * M_PI * k / segments_around;
                anatomy.vertices.row(vertex++) =
                    (point + radius * (std::cos(angle) * u + std::sin(angle) * w)).transpose();
            }
        }
        for (const double end : {shaft.begin, shaft.end}) {
            polyline_at(nodes, end, point, tangent);
            anatomy.vertices.row(vertex++) = point.transpose();
        }
        const auto at = [&](int ring, int k) { return first + ring * segments_around + k % segments_around; };
        for (int k = 0; k < segments_around; ++k) {
            for (int r = 0; r + 1 < rings_per_shaft; ++r) {
                anatomy.triangles.row(triangle++) << at(r, k), at(r, k + 1), at(r + 1, k);
                anatomy.triangles.row(triangle++) << at(r, k + 1), at(r + 1, k + 1), at(r + 1, k);
            }
            anatomy.triangles.row(triangle++) << vertex - 2, at(0, k + 1), at(0, k);
            anatomy.triangles.row(triangle++) << vertex - 1, at(rings_per_shaft - 1, k), at(rings_per_shaft - 1, k + 1);
        }
        AnatomyPart part;
        part.name = shaft.name;
        part.layer = "bone";
        part.vertex_begin = first;
        part.vertex_end = vertex;
        part.triangle_begin = first_triangle;
        part.triangle_end = triangle;
        anatomy.parts.push_back(part);
    }
    return anatomy;
}

}  // namespace ndg
