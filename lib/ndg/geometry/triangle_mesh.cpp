// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/triangle_mesh.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace ndg {
namespace {

/// A directed edge of a triangle. Sorting these by (low, high) vertex brings the triangles of an edge together.
struct HalfEdge {
    int low, high, triangle, opposite;
    bool forward;  ///< the triangle runs low -> high
};

std::vector<HalfEdge> sorted_half_edges(const Eigen::Ref<const Triangles>& triangles)
{
    std::vector<HalfEdge> half_edges;
    half_edges.reserve(static_cast<std::size_t>(3 * triangles.rows()));
    for (int triangle = 0; triangle < triangles.rows(); ++triangle) {
        for (int corner = 0; corner < 3; ++corner) {
            const int from = triangles(triangle, corner);
            const int to = triangles(triangle, (corner + 1) % 3);
            const int opposite = triangles(triangle, (corner + 2) % 3);
            half_edges.push_back({std::min(from, to), std::max(from, to), triangle, opposite, from < to});
        }
    }
    std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    return half_edges;
}

/// First index past those of the same edge as half_edges[begin].
std::size_t edge_end(const std::vector<HalfEdge>& half_edges, std::size_t begin)
{
    std::size_t end = begin + 1;
    while (end < half_edges.size() && half_edges[end].low == half_edges[begin].low &&
           half_edges[end].high == half_edges[begin].high) {
        ++end;
    }
    return end;
}

/// "" or what is wrong with the indices of the triangles.
std::string index_defect(const Eigen::Ref<const Triangles>& triangles, Eigen::Index num_vertices)
{
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int corner = 0; corner < 3; ++corner) {
            const int vertex = triangles(t, corner);
            if (vertex < 0 || vertex >= num_vertices) {
                return fmt::format("index: triangle {} names vertex {} of {}", t, vertex, num_vertices);
            }
        }
        if (triangles(t, 0) == triangles(t, 1) || triangles(t, 1) == triangles(t, 2) ||
            triangles(t, 2) == triangles(t, 0)) {
            return fmt::format("degenerate: triangle {} names a vertex twice", t);
        }
    }
    return "";
}

/// "" or the first edge that has not exactly two triangles of opposite direction.
std::string edge_defect(const Eigen::Ref<const Triangles>& triangles)
{
    const auto half_edges = sorted_half_edges(triangles);
    for (std::size_t begin = 0; begin < half_edges.size();) {
        const std::size_t end = edge_end(half_edges, begin);
        const auto& first = half_edges[begin];
        if (end - begin == 1) return fmt::format("open: edge {}-{} has one triangle", first.low, first.high);
        if (end - begin > 2) {
            return fmt::format("non-manifold: edge {}-{} has {} triangles", first.low, first.high, end - begin);
        }
        if (first.forward == half_edges[begin + 1].forward) {
            return fmt::format("non-manifold: the two triangles of edge {}-{} face opposite ways", first.low,
                               first.high);
        }
        begin = end;
    }
    return "";
}

/// "" or the first vertex whose triangles do not form one fan. Expects an edge-manifold closed surface.
std::string fan_defect(const Eigen::Ref<const Triangles>& triangles, Eigen::Index num_vertices)
{
    // next[k] of corner k: the corner of the same vertex in the triangle across the edge that leaves the vertex.
    const auto half_edges = sorted_half_edges(triangles);
    const auto corner_of = [&](int triangle, int vertex) {
        for (int corner = 0; corner < 2; ++corner) {
            if (triangles(triangle, corner) == vertex) return 3 * triangle + corner;
        }
        return 3 * triangle + 2;
    };
    std::vector<int> next(static_cast<std::size_t>(3 * triangles.rows()));
    for (std::size_t i = 0; i + 1 < half_edges.size(); i += 2) {
        const auto& a = half_edges[i].forward ? half_edges[i] : half_edges[i + 1];
        const auto& b = half_edges[i].forward ? half_edges[i + 1] : half_edges[i];
        next[corner_of(a.triangle, a.low)] = corner_of(b.triangle, a.low);
        next[corner_of(b.triangle, b.high)] = corner_of(a.triangle, b.high);
    }
    std::vector<int> corner_count(num_vertices, 0);
    std::vector<int> any_corner(num_vertices, -1);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int corner = 0; corner < 3; ++corner) {
            const auto vertex = static_cast<std::size_t>(triangles(t, corner));
            ++corner_count[vertex];
            any_corner[vertex] = static_cast<int>(3 * t + corner);
        }
    }
    for (std::size_t vertex = 0; vertex < corner_count.size(); ++vertex) {
        if (corner_count[vertex] == 0) return fmt::format("unused: vertex {} belongs to no triangle", vertex);
        int fan = 0;
        int corner = any_corner[vertex];
        do {
            ++fan;
            corner = next[corner];
        } while (corner != any_corner[vertex]);
        if (fan != corner_count[vertex]) return fmt::format("non-manifold: vertex {} joins several fans", vertex);
    }
    return "";
}

/// "" or the first connected component that encloses a negative volume.
std::string orientation_defect(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    std::vector<int> parent(vertices.rows());
    for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = static_cast<int>(i);
    const auto root_of = [&](int vertex) {
        while (parent[vertex] != vertex) {
            auto& up = parent[vertex];
            up = parent[up];
            vertex = up;
        }
        return vertex;
    };
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int corner = 1; corner < 3; ++corner) {
            const int a = root_of(triangles(t, 0));
            const int b = root_of(triangles(t, corner));
            parent[std::max(a, b)] = std::min(a, b);
        }
    }
    std::map<int, double> volume_of_component;
    const Eigen::RowVector3d centre = vertices.colwise().mean();
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Eigen::Vector3d a = vertices.row(triangles(t, 0)) - centre;
        const Eigen::Vector3d b = vertices.row(triangles(t, 1)) - centre;
        const Eigen::Vector3d c = vertices.row(triangles(t, 2)) - centre;
        volume_of_component[root_of(triangles(t, 0))] += a.cross(b).dot(c) / 6.0;
    }
    for (const auto& [root, volume] : volume_of_component) {
        if (volume <= 0.0) {
            return fmt::format("faces inwards: the part with vertex {} encloses a volume of {:g} m^3", root, volume);
        }
    }
    return "";
}

Eigen::Vector3d area_vector(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                            Eigen::Index triangle)
{
    const Eigen::Vector3d a = vertices.row(triangles(triangle, 0));
    const Eigen::Vector3d b = vertices.row(triangles(triangle, 1));
    const Eigen::Vector3d c = vertices.row(triangles(triangle, 2));
    return 0.5 * (b - a).cross(c - a);
}

}  // namespace

TriangleMesh join_meshes(const std::vector<const TriangleMesh*>& meshes)
{
    Eigen::Index num_vertices = 0, num_triangles = 0;
    for (const TriangleMesh* mesh : meshes) {
        num_vertices += mesh->vertices.rows();
        num_triangles += mesh->triangles.rows();
    }
    TriangleMesh joined{Points(num_vertices, 3), Triangles(num_triangles, 3)};
    Eigen::Index vertex = 0, triangle = 0;
    for (const TriangleMesh* mesh : meshes) {
        joined.vertices.middleRows(vertex, mesh->vertices.rows()) = mesh->vertices;
        joined.triangles.middleRows(triangle, mesh->triangles.rows()) =
            mesh->triangles.array() + static_cast<int>(vertex);
        vertex += mesh->vertices.rows();
        triangle += mesh->triangles.rows();
    }
    return joined;
}

Points vertex_normals(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    Points normals = Points::Zero(vertices.rows(), 3);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Eigen::RowVector3d area = area_vector(vertices, triangles, t).transpose();
        for (int corner = 0; corner < 3; ++corner) normals.row(triangles(t, corner)) += area;
    }
    for (Eigen::Index v = 0; v < normals.rows(); ++v) {
        const double length = normals.row(v).norm();
        if (length > 0.0) normals.row(v) /= length;
    }
    return normals;
}

Points triangle_normals(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    Points normals(triangles.rows(), 3);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Eigen::RowVector3d area = area_vector(vertices, triangles, t).transpose();
        const double length = area.norm();
        normals.row(t) = length > 0.0 ? Eigen::RowVector3d(area / length) : Eigen::RowVector3d(area);
    }
    return normals;
}

Eigen::VectorXd triangle_areas(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    Eigen::VectorXd areas(triangles.rows());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) areas[t] = area_vector(vertices, triangles, t).norm();
    return areas;
}

double enclosed_volume(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    if (vertices.rows() == 0) return 0.0;
    // Summed about the centroid, so that a body far from the origin loses no digits.
    const Eigen::Vector3d centre = vertices.colwise().mean();
    double volume = 0.0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Eigen::Vector3d a = vertices.row(triangles(t, 0)).transpose() - centre;
        volume += a.dot(area_vector(vertices, triangles, t)) / 3.0;
    }
    return volume;
}

std::vector<MeshEdge> mesh_edges(const Eigen::Ref<const Triangles>& triangles, int num_vertices)
{
    const std::string defect = index_defect(triangles, num_vertices);
    if (!defect.empty()) throw Error(defect);
    const auto half_edges = sorted_half_edges(triangles);
    std::vector<MeshEdge> edges;
    edges.reserve(half_edges.size() / 2 + 1);
    for (std::size_t begin = 0; begin < half_edges.size();) {
        const std::size_t end = edge_end(half_edges, begin);
        const auto& first = half_edges[begin];
        require(end - begin <= 2, "edge {}-{} has {} triangles", first.low, first.high, end - begin);
        MeshEdge edge{first.forward ? first.low : first.high,
                      first.forward ? first.high : first.low,
                      first.triangle,
                      -1,
                      first.opposite,
                      -1};
        if (end - begin == 2) {
            const auto& second = half_edges[begin + 1];
            require(first.forward != second.forward, "the two triangles of edge {}-{} face opposite ways", first.low,
                    first.high);
            const auto& left = first.forward ? first : second;
            const auto& right = first.forward ? second : first;
            edge = {left.low, left.high, left.triangle, right.triangle, left.opposite, right.opposite};
        }
        edges.push_back(edge);
        begin = end;
    }
    return edges;
}

std::vector<std::vector<int>> boundary_loops(const Eigen::Ref<const Triangles>& triangles, int num_vertices)
{
    // A vertex where several holes touch has several outgoing boundary edges; each is walked once.
    std::map<int, std::vector<int>> successors;
    for (const auto& edge : mesh_edges(triangles, num_vertices)) {
        if (edge.right_triangle < 0) successors[edge.v0].push_back(edge.v1);
    }
    std::vector<std::vector<int>> loops;
    while (!successors.empty()) {
        const int start = successors.begin()->first;
        std::vector<int> loop;
        int vertex = start;
        do {
            loop.push_back(vertex);
            const auto entry = successors.find(vertex);
            require(entry != successors.end(), "the boundary ends at vertex {}", vertex);
            vertex = entry->second.front();
            entry->second.erase(entry->second.begin());
            if (entry->second.empty()) successors.erase(entry);
        } while (vertex != start);
        loops.push_back(std::move(loop));
    }
    return loops;
}

std::vector<std::vector<int>> vertex_neighbours(const Eigen::Ref<const Triangles>& triangles, int num_vertices)
{
    std::vector<std::vector<int>> neighbours(num_vertices);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int corner = 0; corner < 3; ++corner) {
            const int a = triangles(t, corner);
            const int b = triangles(t, (corner + 1) % 3);
            neighbours[a].push_back(b);
            neighbours[b].push_back(a);
        }
    }
    for (auto& list : neighbours) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return neighbours;
}

Eigen::SparseMatrix<double> cotangent_laplacian(const Eigen::Ref<const Points>& vertices,
                                                const Eigen::Ref<const Triangles>& triangles)
{
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(12 * triangles.rows()));
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const double double_area = 2.0 * area_vector(vertices, triangles, t).norm();
        require(double_area > 0.0, "triangle {} has no area, so its cotangents are undefined", t);
        for (int corner = 0; corner < 3; ++corner) {
            const int apex = triangles(t, corner);
            const int a = triangles(t, (corner + 1) % 3);
            const int b = triangles(t, (corner + 2) % 3);
            const double cotangent =
                (vertices.row(a) - vertices.row(apex)).dot(vertices.row(b) - vertices.row(apex)) / double_area;
            entries.emplace_back(a, a, 0.5 * cotangent);
            entries.emplace_back(b, b, 0.5 * cotangent);
            entries.emplace_back(a, b, -0.5 * cotangent);
            entries.emplace_back(b, a, -0.5 * cotangent);
        }
    }
    Eigen::SparseMatrix<double> laplacian(vertices.rows(), vertices.rows());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    return laplacian;
}

Eigen::VectorXd vertex_areas(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    Eigen::VectorXd areas = Eigen::VectorXd::Zero(vertices.rows());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const double third = area_vector(vertices, triangles, t).norm() / 3.0;
        for (int corner = 0; corner < 3; ++corner) areas[triangles(t, corner)] += third;
    }
    return areas;
}

std::string closed_surface_defect(const Eigen::Ref<const Points>& vertices,
                                  const Eigen::Ref<const Triangles>& triangles)
{
    if (triangles.rows() == 0) return "empty: there are no triangles";
    if (!vertices.allFinite()) return "not finite: a vertex coordinate is not a number";
    std::string defect = index_defect(triangles, vertices.rows());
    if (defect.empty()) defect = edge_defect(triangles);
    if (defect.empty()) defect = fan_defect(triangles, vertices.rows());
    if (defect.empty()) defect = orientation_defect(vertices, triangles);
    return defect;
}

double dihedral_angle(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, const Eigen::Vector3d& left,
                      const Eigen::Vector3d& right)
{
    const Eigen::Vector3d edge = x1 - x0;
    const Eigen::Vector3d left_normal = edge.cross(left - x0);
    const Eigen::Vector3d right_normal = (right - x0).cross(edge);
    // Seen against the edge direction, a convex edge turns the left normal counter-clockwise into the right one.
    const double sine = left_normal.cross(right_normal).dot(edge) / edge.norm();
    const double angle = std::atan2(sine, left_normal.dot(right_normal));
    return angle > -M_PI ? angle : M_PI;
}

}  // namespace ndg
