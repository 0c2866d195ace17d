// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/region_cut.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

namespace ndg {

namespace {

struct CuttingPlane {
    Eigen::RowVector3d point, normal;
    std::vector<int> joints;  ///< the plane counts for vertices that hang on these joints
};

std::vector<CuttingPlane> cutting_planes(const Eigen::Ref<const Points>& joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto at = [&](const std::string& name) -> Eigen::RowVector3d {
        return joint_positions.row(skeleton.joint(name));
    };
    const auto joints_from = [&](const std::vector<std::string>& names) {
        std::vector<int> joints;
        for (const auto& name : names) joints.push_back(skeleton.joint(name));
        for (int j = 0; j < skeleton.num_joints(); ++j)  // with all descendants
            for (const int parent : std::vector<int>(joints))
                if (skeleton.parents[j] == parent && std::find(joints.begin(), joints.end(), j) == joints.end())
                    joints.push_back(j);
        return joints;
    };
    std::vector<CuttingPlane> planes;
    const Eigen::RowVector3d neck = at("head") - at("neck_1");
    planes.push_back({at("neck_1") + 0.4 * neck, neck.normalized(), joints_from({"neck_1"})});
    for (const std::string side : {"left", "right"}) {
        const Eigen::RowVector3d forearm = at(side + "_hand") - at(side + "_forearm");
        planes.push_back({at(side + "_hand") - 0.06 * forearm, forearm.normalized(), joints_from({side + "_forearm"})});
        Eigen::RowVector3d foot = at(side + "_toes") - at(side + "_foot");
        foot.y() = 0.0;
        planes.push_back({at(side + "_toes"), foot.normalized(), joints_from({side + "_foot"})});
    }
    return planes;
}

}  // namespace

Eigen::VectorXd region_field(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const RowMatrix>& weights,
                             const Eigen::Ref<const Points>& joint_positions)
{
    Eigen::VectorXd field = Eigen::VectorXd::Constant(vertices.rows(), -1.0);
    for (const CuttingPlane& plane : cutting_planes(joint_positions))
        for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
            double share = 0.0;
            for (const int joint : plane.joints) share += weights(v, joint);
            if (share > 0.5) field[v] = std::max(field[v], (vertices.row(v) - plane.point).dot(plane.normal));
        }
    return field;
}

CutSurface cut_along_zero(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                          const Eigen::VectorXd& field, double snap)
{
    const auto side = [&](int v) { return std::abs(field[v]) < snap ? 0 : (field[v] < 0 ? -1 : 1); };
    std::vector<Eigen::RowVector3d> points;
    points.reserve(vertices.rows());
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) points.emplace_back(vertices.row(v));
    std::map<std::pair<int, int>, int> split_vertex;
    const auto split = [&](int a, int b) {
        const auto key = std::minmax(a, b);
        const auto found = split_vertex.find(key);
        if (found != split_vertex.end()) return found->second;
        const double t = field[key.first] / (field[key.first] - field[key.second]);
        points.push_back((1.0 - t) * vertices.row(key.first) + t * vertices.row(key.second));
        return split_vertex[key] = static_cast<int>(points.size()) - 1;
    };
    CutSurface cut;
    std::vector<std::array<int, 3>> faces;
    const auto add = [&](int a, int b, int c, int label_side) {
        faces.push_back({a, b, c});
        cut.triangle_labels.push_back(label_side < 0 ? 1 : 0);
    };
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<int, 3> v = {triangles(t, 0), triangles(t, 1), triangles(t, 2)};
        std::array<int, 3> s = {side(v[0]), side(v[1]), side(v[2])};
        const bool negative = s[0] < 0 || s[1] < 0 || s[2]<0, positive = s[0]> 0 || s[1] > 0 || s[2] > 0;
        if (!negative || !positive) {
            // A triangle lying in the line as a whole goes to the volumetric side.
            add(v[0], v[1], v[2], positive ? 1 : -1);
            continue;
        }
        const auto rotate = [&] {
            v = {v[1], v[2], v[0]};
            s = {s[1], s[2], s[0]};
        };
        if (s[0] == 0 || s[1] == 0 || s[2] == 0) {  // one vertex on the line, the opposite edge is crossed
            while (s[0] != 0) rotate();
            const int m = split(v[1], v[2]);
            add(v[0], v[1], m, s[1]);
            add(v[0], m, v[2], s[2]);
        } else {  // one vertex alone on its side
            while (s[1] != s[2]) rotate();
            const int m01 = split(v[0], v[1]), m02 = split(v[0], v[2]);
            add(v[0], m01, m02, s[0]);
            add(m01, v[1], v[2], s[1]);
            add(m01, v[2], m02, s[1]);
        }
    }
    cut.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) cut.vertices.row(i) = points[i];
    cut.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t i = 0; i < faces.size(); ++i) cut.triangles.row(i) << faces[i][0], faces[i][1], faces[i][2];
    return cut;
}

std::vector<int> volumetric_labels(const Eigen::Ref<const Triangles>& triangles, const Eigen::VectorXd& field)
{
    std::vector<int> labels(triangles.rows());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        labels[t] = field[triangles(t, 0)] + field[triangles(t, 1)] + field[triangles(t, 2)] < 0.0 ? 1 : 0;
    const std::vector<MeshEdge> edges = mesh_edges(triangles, static_cast<int>(field.size()));
    constexpr int max_rounds = 20;
    for (int round = 0; round < max_rounds; ++round) {
        std::vector<int> neighbours_of_other_label(triangles.rows(), 0);
        for (const MeshEdge& edge : edges) {
            if (edge.right_triangle < 0 || labels[edge.left_triangle] == labels[edge.right_triangle]) continue;
            ++neighbours_of_other_label[edge.left_triangle];
            ++neighbours_of_other_label[edge.right_triangle];
        }
        // Alternate sides, so that two triangles do not swap for ever.
        const int side = round % 2;
        bool changed = false;
        for (Eigen::Index t = 0; t < triangles.rows(); ++t)
            if (labels[t] == side && neighbours_of_other_label[t] >= 2) {
                labels[t] = 1 - side;
                changed = true;
            }
        if (!changed && side == 1) break;
    }
    return labels;
}

}  // namespace ndg
