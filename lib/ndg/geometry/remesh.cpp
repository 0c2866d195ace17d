// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/remesh.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Constrained_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

namespace simplification = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Face = SurfaceMesh::Face_index;
using LabelMap = SurfaceMesh::Property_map<Face, int>;
using EdgeFlags = SurfaceMesh::Property_map<SurfaceMesh::Edge_index, bool>;

/// Split, collapse, flip, relax and project are repeated this often; edge lengths have settled by then.
constexpr unsigned int remesh_iterations = 10;

Point to_point(const Eigen::RowVector3d& row)
{
    return {row[0], row[1], row[2]};
}

SurfaceMesh to_surface_mesh(const TriangleMesh& mesh, const std::vector<int>& triangle_labels, LabelMap& labels)
{
    SurfaceMesh surface;
    labels = surface.add_property_map<Face, int>("f:label", 0).first;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) surface.add_vertex(to_point(mesh.vertices.row(v)));
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const auto vertex = [&](int corner) {
            return SurfaceMesh::Vertex_index(static_cast<SurfaceMesh::size_type>(mesh.triangles(t, corner)));
        };
        const Face face = surface.add_face(vertex(0), vertex(1), vertex(2));
        require(face != SurfaceMesh::null_face(), "triangle {} does not fit a manifold surface", t);
        labels[face] = triangle_labels[static_cast<std::size_t>(t)];
    }
    return surface;
}

RemeshResult to_result(SurfaceMesh& surface, const LabelMap& labels)
{
    surface.collect_garbage();
    RemeshResult result;
    result.mesh.vertices.resize(static_cast<Eigen::Index>(surface.number_of_vertices()), 3);
    for (const auto vertex : surface.vertices()) {
        const Point& point = surface.point(vertex);
        result.mesh.vertices.row(static_cast<Eigen::Index>(vertex.idx())) << point.x(), point.y(), point.z();
    }
    result.mesh.triangles.resize(static_cast<Eigen::Index>(surface.number_of_faces()), 3);
    result.triangle_labels.reserve(surface.number_of_faces());
    Eigen::Index t = 0;
    for (const Face face : surface.faces()) {
        int corner = 0;
        for (const auto vertex : surface.vertices_around_face(surface.halfedge(face))) {
            result.mesh.triangles(t, corner++) = static_cast<int>(vertex.idx());
        }
        result.triangle_labels.push_back(labels[face]);
        ++t;
    }
    return result;
}

/// Labels of the two faces of an edge of a closed mesh.
std::pair<int, int> edge_labels(const SurfaceMesh& surface, const LabelMap& labels, SurfaceMesh::Edge_index edge)
{
    return {labels[surface.face(surface.halfedge(edge, 0))], labels[surface.face(surface.halfedge(edge, 1))]};
}

/// Gives a triangle with two neighbours of one other label that label: such teeth would become slivers or folds along
/// the border. Every change shortens the border by an edge or more, so it ends.
void cut_teeth(const SurfaceMesh& surface, LabelMap& labels)
{
    bool changed = true;
    while (changed) {
        changed = false;
        for (const Face face : surface.faces()) {
            std::array<int, 3> neighbours{};
            std::size_t side = 0;
            for (const auto halfedge : surface.halfedges_around_face(surface.halfedge(face))) {
                neighbours[side++] = labels[surface.face(surface.opposite(halfedge))];
            }
            std::sort(neighbours.begin(), neighbours.end());
            // Of three sorted labels, one that occurs twice is the middle one.
            const bool twice = neighbours[0] == neighbours[1] || neighbours[1] == neighbours[2];
            if (twice && neighbours[1] != labels[face]) {
                labels[face] = neighbours[1];
                changed = true;
            }
        }
    }
}

void remesh_labelled(SurfaceMesh& surface, const LabelMap& labels, double target_edge_length)
{
    std::vector<Face> faces;
    for (const Face face : surface.faces()) {
        if (labels[face] > 0) faces.push_back(face);
    }
    if (faces.empty()) return;
    // Edges between two labels are borders of CGAL's patches: they are split and collapsed along the border, so that
    // it gets edges of the target length, but never flipped or crossed.
    CGAL::Polygon_mesh_processing::isotropic_remeshing(faces, target_edge_length, surface,
                                                       CGAL::parameters::number_of_iterations(remesh_iterations)
                                                           .number_of_relaxation_steps(3)
                                                           .face_patch_map(labels)
                                                           .protect_constraints(false)
                                                           .relax_constraints(false));
}

/// Splits and collapses leave the vertices of borders on chords of the original surface; this puts them back onto it.
void project_borders(SurfaceMesh& surface, const LabelMap& labels, const TriangleTree& original)
{
    for (const auto edge : surface.edges()) {
        const auto [left, right] = edge_labels(surface, labels, edge);
        if (left == right) continue;
        for (int side = 0; side < 2; ++side) {
            Point& point = surface.point(surface.vertex(edge, static_cast<unsigned int>(side)));
            const Eigen::Vector3d nearest = original.closest({point.x(), point.y(), point.z()}).point;
            point = Point(nearest[0], nearest[1], nearest[2]);
        }
    }
}

void decimate_unlabelled(SurfaceMesh& surface, const LabelMap& labels, std::size_t target_faces)
{
    std::size_t num_faces = 0;
    for (const Face face : surface.faces()) num_faces += labels[face] == 0 ? 1 : 0;
    if (num_faces <= target_faces) return;

    EdgeFlags fixed = surface.add_property_map<SurfaceMesh::Edge_index, bool>("e:fixed", false).first;
    for (const auto edge : surface.edges()) {
        const auto [left, right] = edge_labels(surface, labels, edge);
        fixed[edge] = left != 0 || right != 0;
    }
    using Policies = simplification::GarlandHeckbert_plane_policies<SurfaceMesh, Kernel>;
    const Policies policies(surface);
    const simplification::Constrained_placement<Policies::Get_placement, EdgeFlags> placement(fixed,
                                                                                              policies.get_placement());
    // A collapse takes two faces and three edges away.
    const std::size_t edges_to_remove = 3 * ((num_faces - target_faces) / 2);
    const simplification::Count_stop_predicate<SurfaceMesh> stop(surface.number_of_edges() - edges_to_remove + 1);
    simplification::edge_collapse(surface, stop,
                                  CGAL::parameters::edge_is_constrained_map(fixed)
                                      .get_cost(policies.get_cost())
                                      .get_placement(placement)
                                      .filter(simplification::Bounded_normal_change_filter<>()));
}

/// A triangle as its exact set of points: a flat one is the longest of its edges.
struct Element {
    Kernel::Triangle_3 triangle;
    Kernel::Segment_3 segment;
    bool flat;
};

Element to_element(const Point& a, const Point& b, const Point& c)
{
    Element element{Kernel::Triangle_3(a, b, c), Kernel::Segment_3(a, b), CGAL::collinear(a, b, c)};
    for (const Kernel::Segment_3& edge : {Kernel::Segment_3(b, c), Kernel::Segment_3(c, a)}) {
        if (edge.squared_length() > element.segment.squared_length()) element.segment = edge;
    }
    return element;
}

bool intersect(const Element& a, const Element& b)
{
    if (!a.flat && !b.flat) return CGAL::do_intersect(a.triangle, b.triangle);
    if (a.flat && b.flat) return CGAL::do_intersect(a.segment, b.segment);
    return a.flat ? CGAL::do_intersect(b.triangle, a.segment) : CGAL::do_intersect(a.triangle, b.segment);
}

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

struct BoxedSurface {
    std::vector<Element> elements;
    std::vector<Box> boxes;

    BoxedSurface(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
    {
        elements.reserve(static_cast<std::size_t>(triangles.rows()));
        boxes.reserve(elements.capacity());
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            elements.push_back(to_element(to_point(vertices.row(triangles(t, 0))),
                                          to_point(vertices.row(triangles(t, 1))),
                                          to_point(vertices.row(triangles(t, 2)))));
            boxes.emplace_back(elements.back().triangle.bbox(), static_cast<int>(t));
        }
    }
    const Element& operator[](int t) const { return elements[static_cast<std::size_t>(t)]; }
};

/// Whether triangles with common vertices meet elsewhere too. Corners of each from the first common one on.
bool neighbours_intersect(const Element& s, const Element& t, const std::vector<std::pair<int, int>>& common)
{
    if (s.flat || t.flat) return false;
    if (common.size() == 3) return true;
    const auto [i, j] = common[0];
    if (common.size() == 1) {
        // The segment in which they meet, if any, ends on the side opposite the common vertex of one of them.
        return CGAL::do_intersect(t.triangle, Kernel::Segment_3(s.triangle.vertex(i + 1), s.triangle.vertex(i + 2))) ||
               CGAL::do_intersect(s.triangle, Kernel::Segment_3(t.triangle.vertex(j + 1), t.triangle.vertex(j + 2)));
    }
    const auto [k, l] = common[1];
    const Point &a = s.triangle.vertex(i), &b = s.triangle.vertex(k), &c = s.triangle.vertex(3 - i - k),
                &d = t.triangle.vertex(3 - j - l);
    return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
}

}  // namespace

RemeshResult remesh_regions(const TriangleMesh& mesh, const std::vector<int>& triangle_labels,
                            double target_edge_length, double keep_ratio)
{
    require_input(static_cast<Eigen::Index>(triangle_labels.size()) == mesh.triangles.rows(),
                  "the mesh to remesh has {} triangles but {} labels", mesh.triangles.rows(), triangle_labels.size());
    require_input(std::isfinite(target_edge_length) && target_edge_length > 0.0,
                  "the target edge length {} is not positive", target_edge_length);
    require_input(keep_ratio > 0.0 && keep_ratio <= 1.0, "the keep ratio {} is not in (0, 1]", keep_ratio);
    for (std::size_t t = 0; t < triangle_labels.size(); ++t) {
        require_input(triangle_labels[t] >= 0, "triangle {} has the negative label {}", t, triangle_labels[t]);
    }
    const std::string defect = closed_surface_defect(mesh.vertices, mesh.triangles);
    require_input(defect.empty(), "the mesh to remesh is not a closed outward surface ({})", defect);

    RemeshResult result;
    try {
        LabelMap labels;
        SurfaceMesh surface = to_surface_mesh(mesh, triangle_labels, labels);
        cut_teeth(surface, labels);
        remesh_labelled(surface, labels, target_edge_length);
        project_borders(surface, labels, TriangleTree(mesh.vertices, mesh.triangles));
        const auto unlabelled = std::count(triangle_labels.begin(), triangle_labels.end(), 0);
        if (keep_ratio < 1.0) {
            decimate_unlabelled(surface, labels,
                                static_cast<std::size_t>(std::lround(keep_ratio * static_cast<double>(unlabelled))));
        }
        result = to_result(surface, labels);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        throw Error(fmt::format("CGAL failed to remesh: {}", error.what()));
    }
    const std::string result_defect = closed_surface_defect(result.mesh.vertices, result.mesh.triangles);
    require(result_defect.empty(), "remeshing to edges of {} m broke the surface ({})", target_edge_length,
            result_defect);
    return result;
}

std::vector<std::pair<int, int>> self_intersections(const Eigen::Ref<const Points>& vertices,
                                                    const Eigen::Ref<const Triangles>& triangles, bool with_neighbours)
{
    BoxedSurface surface(vertices, triangles);
    std::vector<std::pair<int, int>> pairs;
    CGAL::box_self_intersection_d(surface.boxes.begin(), surface.boxes.end(), [&](const Box& a, const Box& b) {
        const int s = std::min(a.info(), b.info());
        const int t = std::max(a.info(), b.info());
        std::vector<std::pair<int, int>> common;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (triangles(s, i) == triangles(t, j)) common.emplace_back(i, j);
        if (common.empty() ? intersect(surface[s], surface[t])
                           : with_neighbours && neighbours_intersect(surface[s], surface[t], common))
            pairs.emplace_back(s, t);
    });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

std::vector<std::pair<int, int>> surface_intersections(const Eigen::Ref<const Points>& first_vertices,
                                                       const Eigen::Ref<const Triangles>& first_triangles,
                                                       const Eigen::Ref<const Points>& second_vertices,
                                                       const Eigen::Ref<const Triangles>& second_triangles)
{
    BoxedSurface first(first_vertices, first_triangles), second(second_vertices, second_triangles);
    std::vector<std::pair<int, int>> pairs;
    CGAL::box_intersection_d(first.boxes.begin(), first.boxes.end(), second.boxes.begin(), second.boxes.end(),
                             [&](const Box& a, const Box& b) {
                                 if (intersect(first[a.info()], second[b.info()]))
                                     pairs.emplace_back(a.info(), b.info());
                             });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

}  // namespace ndg
