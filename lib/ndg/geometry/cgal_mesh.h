// SPDX-License-Identifier: Apache-2.0
// Internal to ndg::cgal: triangle meshes as CGAL's and back.
#pragma once

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

namespace ndg {

using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<CgalKernel::Point_3>;

/// Vertices and faces in the mesh's order. Throws InputError naming a triangle that fits no manifold surface.
inline CgalMesh to_cgal(const TriangleMesh& mesh)
{
    CgalMesh surface;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        surface.add_vertex(CgalKernel::Point_3(mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)));
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const auto vertex = [&](int corner) {
            return CgalMesh::Vertex_index(static_cast<CgalMesh::size_type>(mesh.triangles(t, corner)));
        };
        const auto face = surface.add_face(vertex(0), vertex(1), vertex(2));
        require_input(face != CgalMesh::null_face(), "triangle {} does not fit a manifold surface", t);
    }
    return surface;
}

/// Triangles in the order of surface.faces(). Removes what the surface has marked as deleted.
inline TriangleMesh from_cgal(CgalMesh& surface)
{
    surface.collect_garbage();
    TriangleMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(surface.number_of_vertices()), 3);
    for (const auto vertex : surface.vertices()) {
        const CgalKernel::Point_3& point = surface.point(vertex);
        mesh.vertices.row(static_cast<Eigen::Index>(vertex.idx())) << point.x(), point.y(), point.z();
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(surface.number_of_faces()), 3);
    Eigen::Index t = 0;
    for (const auto face : surface.faces()) {
        int corner = 0;
        for (const auto vertex : surface.vertices_around_face(surface.halfedge(face)))
            mesh.triangles(t, corner++) = static_cast<int>(vertex.idx());
        ++t;
    }
    return mesh;
}

}  // namespace ndg
