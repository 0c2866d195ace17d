// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/cut_away.h"

#include <array>
#include <map>
#include <utility>

namespace ndg {
namespace {

const Eigen::Vector3f fat_colour(0.95f, 0.80f, 0.50f);  // of sections

/// Distances of points from the plane, m; positive: cut away.
Eigen::VectorXd heights_above(const Eigen::Ref<const Points>& points, const ClipPlane& plane)
{
    return (points.rowwise() - plane.point.transpose()) * plane.normal.normalized();
}

/// Share of the way from a to b at which a line leaves the plane.
double crossing(double height_a, double height_b)
{
    return height_a / (height_a - height_b);
}

}  // namespace

SceneSurface cut_surface(const SceneSurface& surface, const ClipPlane& plane)
{
    check_surface(surface);
    const Eigen::VectorXd height = heights_above(surface.vertices, plane);
    const bool coloured = surface.vertex_colours.rows() > 0;
    std::vector<Eigen::RowVector3d> added;
    std::vector<Eigen::RowVector3f> added_colours;
    std::map<std::pair<int, int>, int> cut_edges;  // shared by the triangles beside an edge
    const int num_old = int(surface.vertices.rows());
    const auto cut_edge = [&](int a, int b) {
        if (a > b) std::swap(a, b);
        const auto [entry, inserted] = cut_edges.emplace(std::pair(a, b), num_old + int(added.size()));
        if (inserted) {
            const double t = crossing(height[a], height[b]);
            added.push_back((1 - t) * surface.vertices.row(a) + t * surface.vertices.row(b));
            if (coloured)
                added_colours.push_back(float(1 - t) * surface.vertex_colours.row(a) +
                                        float(t) * surface.vertex_colours.row(b));
        }
        return entry->second;
    };
    std::vector<std::array<int, 3>> kept;
    for (Eigen::Index i = 0; i < surface.triangles.rows(); ++i) {
        std::array<int, 4> polygon{};
        int corners = 0;
        for (int k = 0; k < 3; ++k) {
            const int a = surface.triangles(i, k), b = surface.triangles(i, (k + 1) % 3);
            const bool a_stays = height[a] <= 0, b_stays = height[b] <= 0;
            if (a_stays) polygon[corners++] = a;
            if (a_stays != b_stays) polygon[corners++] = cut_edge(a, b);
        }
        for (int k = 2; k < corners; ++k) kept.push_back({polygon[0], polygon[k - 1], polygon[k]});
    }
    SceneSurface result = surface;
    result.vertices.conservativeResize(num_old + Eigen::Index(added.size()), 3);
    if (coloured) result.vertex_colours.conservativeResize(result.vertices.rows(), 3);
    for (std::size_t i = 0; i < added.size(); ++i) {
        result.vertices.row(num_old + Eigen::Index(i)) = added[i];
        if (coloured) result.vertex_colours.row(num_old + Eigen::Index(i)) = added_colours[i];
    }
    result.triangles.resize(Eigen::Index(kept.size()), 3);
    for (std::size_t i = 0; i < kept.size(); ++i)
        result.triangles.row(Eigen::Index(i)) << kept[i][0], kept[i][1], kept[i][2];
    return result;
}

SceneSurface cut_face(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms,
                      const ClipPlane& plane)
{
    const Eigen::VectorXd height = heights_above(vertices, plane);
    // Tetrahedra that fill a prism. Neighbours need not split a quadrilateral side along the same diagonal: all points
    // of the cut lie in the plane, and a gap is as thin as that side is bent.
    constexpr std::array<std::array<int, 4>, 3> tetrahedra = {{{0, 1, 2, 3}, {1, 2, 3, 4}, {2, 3, 4, 5}}};
    std::vector<Eigen::RowVector3d> points;
    for (Eigen::Index p = 0; p < prisms.rows(); ++p)
        for (const std::array<int, 4>& corners : tetrahedra) {
            std::array<int, 4> above{}, below{};
            int num_above = 0, num_below = 0;
            for (const int corner : corners) {
                const int vertex = prisms(p, corner);
                if (height[vertex] > 0)
                    above[num_above++] = vertex;
                else
                    below[num_below++] = vertex;
            }
            const auto cut = [&](int a, int b) -> Eigen::RowVector3d {
                const double t = crossing(height[a], height[b]);
                return (1 - t) * vertices.row(a) + t * vertices.row(b);
            };
            const auto add = [&](Eigen::RowVector3d a, Eigen::RowVector3d b, const Eigen::RowVector3d& c) {
                if ((b - a).cross(c - a).dot(plane.normal.transpose()) < 0) std::swap(a, b);
                points.insert(points.end(), {a, b, c});
            };
            if (num_above == 1) add(cut(above[0], below[0]), cut(above[0], below[1]), cut(above[0], below[2]));
            if (num_below == 1) add(cut(above[0], below[0]), cut(above[1], below[0]), cut(above[2], below[0]));
            if (num_above == 2) {
                const Eigen::RowVector3d one = cut(above[0], below[0]), other = cut(above[1], below[1]);
                add(one, cut(above[0], below[1]), other);
                add(one, cut(above[1], below[0]), other);
            }
        }
    SceneSurface face;
    face.name = "cut_face";
    face.vertices.resize(Eigen::Index(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) face.vertices.row(Eigen::Index(i)) = points[i];
    face.triangles.resize(Eigen::Index(points.size()) / 3, 3);
    for (Eigen::Index i = 0; i < face.triangles.rows(); ++i)
        face.triangles.row(i) << int(3 * i), int(3 * i) + 1, int(3 * i) + 2;
    face.gloss = 0.0f;
    return face;
}

std::vector<SceneSurface> cut_away_surfaces(const Template& body_template, const BodyGeometry& geometry,
                                            const ClipPlane& plane)
{
    std::vector<SceneSurface> surfaces = anatomy_surfaces(body_template, geometry);
    bool has_muscles = false;
    for (const SceneSurface& surface : surfaces) has_muscles = has_muscles || surface.name == "muscles";
    if (!has_muscles) surfaces.push_back(muscle_wrap_surface(body_template, geometry));
    SceneSurface fat =
        cut_face(geometry.volume_vertices,
                 body_template.prisms.bottomRows(body_template.num_prisms() - body_template.fat_begin()), plane);
    fat.colour = fat_colour;
    SceneSurface skin = cut_surface(skin_surface(body_template, geometry), plane);
    for (SceneSurface* surface : {&fat, &skin})
        if (surface->triangles.rows() > 0) surfaces.push_back(std::move(*surface));
    return surfaces;
}

}  // namespace ndg
