// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/region_cut.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

namespace ndg {

const std::vector<std::string> skin_region_names = {"body",       "head",      "left_hand",
                                                    "right_hand", "left_toes", "right_toes"};

namespace {

constexpr double plane_snap = 1e-5;  ///< m; vertices this near to a cutting plane count as lying on it

int region_index(const std::string& name)
{
    const auto found = std::find(skin_region_names.begin(), skin_region_names.end(), name);
    return static_cast<int>(found - skin_region_names.begin());
}

/// Distances to a plane where they matter for the cut: on the vertices of the part beyond it and on their neighbours;
/// -1 elsewhere, so that the endless plane cuts nothing else.
Eigen::VectorXd part_field(const Eigen::Ref<const Points>& vertices, const std::vector<std::vector<int>>& neighbours,
                           const Eigen::Ref<const RowMatrix>& weights, const CuttingPlane& plane)
{
    const Eigen::VectorXd distance = (vertices.rowwise() - plane.point) * plane.normal.transpose();
    Eigen::Index seed = -1;
    double most = 0.5;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        double share = 0.0;
        for (const int joint : plane.far_joints) share += weights(v, joint);
        if (distance[v] <= 0.0 || share <= most + 1e-12) continue;
        most = share;
        seed = v;
    }
    require_input(seed >= 0,
                  "the skin has no vertex that belongs to the {} beyond its cutting plane at {:.3f} {:.3f} "
                  "{:.3f}",
                  skin_region_names[plane.region], plane.point[0], plane.point[1], plane.point[2]);
    Eigen::VectorXd field = Eigen::VectorXd::Constant(vertices.rows(), -1.0);
    std::vector<int> open = {static_cast<int>(seed)};
    field[seed] = distance[seed];
    while (!open.empty()) {
        const int v = open.back();
        open.pop_back();
        for (const int other : neighbours[v]) {
            if (field[other] != -1.0) continue;
            field[other] = distance[other];
            if (distance[other] > 0.0) open.push_back(other);
        }
    }
    return field;
}

}  // namespace

std::vector<CuttingPlane> cutting_planes(const Eigen::Ref<const Points>& joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto at = [&](const std::string& name) -> Eigen::RowVector3d {
        return joint_positions.row(skeleton.joint(name));
    };
    const auto joints_from = [&](const std::string& name) {
        std::vector<int> joints = {skeleton.joint(name)};
        for (int j = 0; j < skeleton.num_joints(); ++j)  // parents stand before their children
            if (std::find(joints.begin(), joints.end(), skeleton.parents[j]) != joints.end()) joints.push_back(j);
        return joints;
    };
    std::vector<CuttingPlane> planes;
    const Eigen::RowVector3d neck = at("head") - at("neck_1");
    planes.push_back({region_index("head"), at("neck_1") + 0.4 * neck, neck.normalized(), joints_from("neck_1"),
                      joints_from("head")});
    for (const std::string side : {"left", "right"}) {
        const Eigen::RowVector3d forearm = at(side + "_hand") - at(side + "_forearm");
        planes.push_back({region_index(side + "_hand"), at(side + "_hand") - 0.06 * forearm, forearm.normalized(),
                          joints_from(side + "_forearm"), joints_from(side + "_hand")});
        Eigen::RowVector3d foot = at(side + "_toes") - at(side + "_foot");
        foot.y() = 0.0;
        planes.push_back({region_index(side + "_toes"), at(side + "_toes"), foot.normalized(),
                          joints_from(side + "_foot"), joints_from(side + "_toes")});
    }
    return planes;
}

RegionCut cut_regions(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                      const Eigen::Ref<const RowMatrix>& weights, const Eigen::Ref<const Points>& joint_positions)
{
    RegionCut result{vertices, triangles, std::vector<int>(static_cast<std::size_t>(triangles.rows()), 0)};
    const auto neighbours = vertex_neighbours(triangles, static_cast<int>(vertices.rows()));
    for (const CuttingPlane& plane : cutting_planes(joint_positions)) {
        // The cuts lie apart: vertices added by another one are none of this plane's business.
        const Eigen::VectorXd part = part_field(vertices, neighbours, weights, plane);
        Eigen::VectorXd field = Eigen::VectorXd::Constant(result.vertices.rows(), -1.0);
        field.head(vertices.rows()) = part;
        const CutSurface cut = cut_along_zero(result.vertices, result.triangles, field, plane_snap);
        std::vector<int> regions;
        std::vector<int> rows;
        for (std::size_t t = 0; t < cut.triangle_labels.size(); ++t) {
            const int before = result.regions[cut.triangle_parents[t]];
            regions.push_back(cut.triangle_labels[t] == 1 ? before : plane.region);
            if (cut.triangle_labels[t] == 0) rows.push_back(static_cast<int>(t));
        }
        const std::size_t loops =
            boundary_loops(cut.triangles(rows, Eigen::all), static_cast<int>(cut.vertices.rows())).size();
        require_input(loops == 1, "the cut of the {} crosses the skin in {} loops instead of one",
                      skin_region_names[plane.region], loops);
        result = {cut.vertices, cut.triangles, std::move(regions)};
    }
    return result;
}

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
    int parent = 0;
    const auto add = [&](int a, int b, int c, int label_side) {
        faces.push_back({a, b, c});
        cut.triangle_parents.push_back(parent);
        cut.triangle_labels.push_back(label_side < 0 ? 1 : 0);
    };
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        parent = static_cast<int>(t);
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

}  // namespace ndg
