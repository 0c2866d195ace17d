// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/simplify.h"

#include "ndg/core/error.h"
#include "ndg/geometry/cgal_mesh.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <CGAL/boost/graph/helpers.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace ndg {
namespace {

constexpr double min_kept_volume = 0.1;  ///< share of its volume that a simplified surface keeps

namespace pmp = CGAL::Polygon_mesh_processing;
namespace simplification = CGAL::Surface_mesh_simplification;
using Point = CgalKernel::Point_3;

/// Merges vertices by rounded position and drops flat and doubled triangles.
void merge_soup(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                double merge_distance, std::vector<Point>& points, std::vector<std::vector<std::size_t>>& polygons)
{
    std::map<std::array<long long, 3>, std::size_t> merged;
    std::vector<std::size_t> index_of(vertices.rows());
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        std::array<long long, 3> key{};
        for (int k = 0; k < 3; ++k) key[std::size_t(k)] = std::llround(vertices(v, k) / merge_distance);
        const auto [found, inserted] = merged.emplace(key, points.size());
        if (inserted) points.emplace_back(vertices(v, 0), vertices(v, 1), vertices(v, 2));
        index_of[v] = found->second;
    }
    std::set<std::array<std::size_t, 3>> seen;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<std::size_t, 3> corners{};
        for (int k = 0; k < 3; ++k) corners[std::size_t(k)] = index_of[triangles(t, k)];
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
        std::array<std::size_t, 3> sorted = corners;
        std::sort(sorted.begin(), sorted.end());
        if (seen.insert(sorted).second) polygons.push_back({corners[0], corners[1], corners[2]});
    }
}

void fill_holes(CgalMesh& surface)
{
    std::vector<CgalMesh::Halfedge_index> borders;
    for (const auto halfedge : surface.halfedges()) {
        if (!surface.is_border(halfedge)) continue;
        auto around = halfedge;
        auto smallest = halfedge;
        do {
            smallest = std::min(smallest, around);
            around = surface.next(around);
        } while (around != halfedge);
        if (smallest == halfedge) borders.push_back(halfedge);
    }
    for (const auto border : borders) {
        if (!surface.is_border(border)) continue;
        std::vector<CgalMesh::Face_index> patch;
        pmp::triangulate_hole(surface, border, std::back_inserter(patch));
        if (!patch.empty()) continue;
        // No triangulation of the border itself avoids edges that exist already: a fan around its centre does.
        double x = 0, y = 0, z = 0, count = 0;
        for (const auto halfedge : surface.halfedges_around_face(border)) {
            const Point& point = surface.point(surface.target(halfedge));
            x += point.x(), y += point.y(), z += point.z(), count += 1;
        }
        CGAL::Euler::fill_hole(border, surface);
        const auto centre = CGAL::Euler::add_center_vertex(border, surface);
        surface.point(surface.target(centre)) = Point(x / count, y / count, z / count);
    }
}

/// The mesh cut into connected components.
std::vector<TriangleMesh> split_components(const TriangleMesh& mesh)
{
    const auto num_vertices = static_cast<std::size_t>(mesh.vertices.rows());
    std::vector<int> parent(num_vertices);
    for (std::size_t v = 0; v < num_vertices; ++v) parent[v] = int(v);
    const auto root = [&](int v) {
        while (parent[std::size_t(v)] != v) v = parent[std::size_t(v)];
        return v;
    };
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
        for (int k = 1; k < 3; ++k) {
            const int a = root(mesh.triangles(t, 0)), b = root(mesh.triangles(t, k));
            if (a != b) parent[std::size_t(std::max(a, b))] = std::min(a, b);
        }
    std::map<int, std::vector<Eigen::Index>> triangles_of;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) triangles_of[root(mesh.triangles(t, 0))].push_back(t);
    std::vector<TriangleMesh> components;
    std::vector<int> local(num_vertices, -1);
    for (const auto& [unused, members] : triangles_of) {
        std::vector<int> kept;
        TriangleMesh component;
        component.triangles.resize(static_cast<Eigen::Index>(members.size()), 3);
        for (std::size_t i = 0; i < members.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                const int v = mesh.triangles(members[i], k);
                if (local[std::size_t(v)] < 0) {
                    local[std::size_t(v)] = int(kept.size());
                    kept.push_back(v);
                }
                component.triangles(Eigen::Index(i), k) = local[std::size_t(v)];
            }
        component.vertices.resize(static_cast<Eigen::Index>(kept.size()), 3);
        for (std::size_t i = 0; i < kept.size(); ++i)
            component.vertices.row(Eigen::Index(i)) = mesh.vertices.row(kept[i]);
        components.push_back(std::move(component));
    }
    return components;
}

bool is_closed(const TriangleMesh& mesh)
{
    return count_open_edges(mesh.triangles) == 0;
}

/// Whether a component lies inside another: all its vertices are (a sample of them, since neither crosses the other
/// more than in spots).
bool lies_inside(const TriangleMesh& inner, const TriangleMesh& outer)
{
    const Eigen::RowVector3d low = outer.vertices.colwise().minCoeff(), high = outer.vertices.colwise().maxCoeff();
    if ((inner.vertices.colwise().minCoeff().array() < low.array()).any()) return false;
    if ((inner.vertices.colwise().maxCoeff().array() > high.array()).any()) return false;
    const Eigen::Index step = std::max<Eigen::Index>(1, inner.vertices.rows() / 16);
    Points sample((inner.vertices.rows() + step - 1) / step, 3);
    for (Eigen::Index i = 0; i < sample.rows(); ++i) sample.row(i) = inner.vertices.row(i * step);
    return winding_numbers(outer.vertices, outer.triangles, sample).minCoeff() > 0.5;
}

}  // namespace

int count_open_edges(const Eigen::Ref<const Triangles>& triangles)
{
    std::vector<std::pair<int, int>> edges;
    edges.reserve(triangles.size());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) edges.emplace_back(triangles(t, k), triangles(t, (k + 1) % 3));
    std::sort(edges.begin(), edges.end());
    int open = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const bool doubled = (i > 0 && edges[i - 1] == edges[i]) || (i + 1 < edges.size() && edges[i + 1] == edges[i]);
        const std::pair<int, int> opposite(edges[i].second, edges[i].first);
        if (doubled || !std::binary_search(edges.begin(), edges.end(), opposite)) ++open;
    }
    return open;
}

TriangleMesh repair_closed(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                           double merge_distance, double min_component_share)
{
    require_input(std::isfinite(merge_distance) && merge_distance > 0.0, "the merge distance {} is not positive",
                  merge_distance);
    std::vector<Point> points;
    std::vector<std::vector<std::size_t>> polygons;
    merge_soup(vertices, triangles, merge_distance, points, polygons);
    require_input(!polygons.empty(), "the surface has no triangles");
    pmp::orient_polygon_soup(points, polygons);
    CgalMesh surface;
    pmp::polygon_soup_to_polygon_mesh(points, polygons, surface);
    pmp::stitch_borders(surface);
    fill_holes(surface);

    std::vector<TriangleMesh> components;
    for (TriangleMesh& component : split_components(from_cgal(surface))) {
        if (!is_closed(component)) continue;
        if (enclosed_volume(component.vertices, component.triangles) < 0.0)
            component.triangles.col(1).swap(component.triangles.col(2));
        components.push_back(std::move(component));
    }
    require_input(!components.empty(), "the surface has no closed component");
    std::vector<double> areas;
    for (const TriangleMesh& component : components) {
        areas.push_back(triangle_areas(component.vertices, component.triangles).sum());
        // Two sheets on top of each other enclose nothing.
        if (enclosed_volume(component.vertices, component.triangles) < merge_distance * areas.back()) areas.back() = 0;
    }
    const double largest = *std::max_element(areas.begin(), areas.end());
    std::vector<TriangleMesh> large, kept;
    std::vector<double> volumes;
    for (std::size_t i = 0; i < components.size(); ++i)
        if (areas[i] > 0.0 && areas[i] >= min_component_share * largest) large.push_back(components[i]);
    require_input(!large.empty(), "the surface encloses no volume");
    for (const TriangleMesh& component : large)
        volumes.push_back(enclosed_volume(component.vertices, component.triangles));
    for (std::size_t i = 0; i < large.size(); ++i) {
        bool hidden = false;
        for (std::size_t j = 0; j < large.size() && !hidden; ++j)
            hidden = j != i && volumes[j] > volumes[i] && lies_inside(large[i], large[j]);
        if (!hidden) kept.push_back(large[i]);
    }
    return join_meshes(kept);
}

TriangleMesh simplify_closed(const TriangleMesh& mesh, int target_vertices)
{
    require_input(target_vertices >= 4, "a closed surface has at least 4 vertices, not {}", target_vertices);
    require_input(mesh.triangles.rows() > 0 && is_closed(mesh), "the surface to simplify is not closed");
    if (mesh.vertices.rows() <= target_vertices) return mesh;
    CgalMesh surface = to_cgal(mesh);
    using Policies = simplification::GarlandHeckbert_plane_policies<CgalMesh, CgalKernel>;
    const Policies policies(surface);
    // A collapse takes a vertex and three edges away.
    const std::size_t edges = 3 * static_cast<std::size_t>(mesh.vertices.rows() - target_vertices);
    const std::size_t keep = surface.number_of_edges() > edges ? surface.number_of_edges() - edges : 6;
    simplification::edge_collapse(surface, simplification::Count_stop_predicate<CgalMesh>(keep + 1),
                                  CGAL::parameters::get_cost(policies.get_cost())
                                      .get_placement(policies.get_placement())
                                      .filter(simplification::Bounded_normal_change_filter<>()));
    TriangleMesh simplified = from_cgal(surface);
    // A scrap that was thinner than its new triangles are wide may have turned inside out.
    std::vector<TriangleMesh> kept;
    for (TriangleMesh& component : split_components(simplified))
        if (enclosed_volume(component.vertices, component.triangles) > 0.0) kept.push_back(std::move(component));
    // A sheet thinner than that all but vanishes: it gets more vertices.
    double volume = 0.0;
    for (const TriangleMesh& component : kept) volume += enclosed_volume(component.vertices, component.triangles);
    if (volume < min_kept_volume * enclosed_volume(mesh.vertices, mesh.triangles))
        return simplify_closed(mesh, 2 * target_vertices);
    return join_meshes(kept);
}

}  // namespace ndg
