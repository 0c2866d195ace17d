// SPDX-License-Identifier: Apache-2.0
// Triangle meshes, and plain functions on their vertex and index arrays.
#pragma once

#include "ndg/core/types.h"

#include <Eigen/SparseCore>

#include <string>
#include <vector>

namespace ndg {

struct TriangleMesh {
    Points vertices;      ///< N x 3
    Triangles triangles;  ///< T x 3
};

/// A mesh and a label for each triangle.
struct LabelledMesh {
    TriangleMesh mesh;
    std::vector<int> triangle_labels;
};

/// Meshes as one, one after the other.
TriangleMesh join_meshes(const std::vector<const TriangleMesh*>& meshes);
template <typename Mesh>
TriangleMesh join_meshes(const std::vector<Mesh>& meshes)
{
    std::vector<const TriangleMesh*> pointers;
    for (const TriangleMesh& mesh : meshes) pointers.push_back(&mesh);
    return join_meshes(pointers);
}
/// The way back: gives each mesh its rows of the joined mesh's vertices.
template <typename Mesh>
void take_joined_vertices(const Eigen::Ref<const Points>& joined, std::vector<Mesh>& meshes)
{
    Eigen::Index next = 0;
    for (TriangleMesh& mesh : meshes) {
        mesh.vertices = joined.middleRows(next, mesh.vertices.rows()).eval();
        next += mesh.vertices.rows();
    }
}

/// Area-weighted unit normals of vertices, N x 3 (zero for unreferenced vertices).
Points vertex_normals(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);
/// Unit normals of triangles, T x 3.
Points triangle_normals(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);
/// Areas, T.
Eigen::VectorXd triangle_areas(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);
/// Signed volume enclosed by a closed, consistently oriented mesh; positive when normals point outwards.
double enclosed_volume(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);

/// Every undirected edge once: (v0, v1, left triangle, right triangle or -1, opposite vertex left, opposite right or
/// -1). The left triangle contains the directed edge v0 -> v1. Order is deterministic. Throws Error for an edge with
/// more than two triangles or with two triangles of opposite orientation.
struct MeshEdge {
    int v0, v1, left_triangle, right_triangle, left_vertex, right_vertex;
};
std::vector<MeshEdge> mesh_edges(const Eigen::Ref<const Triangles>& triangles, int num_vertices);

/// Boundary loops, each a closed chain of vertices with the surface on its left.
std::vector<std::vector<int>> boundary_loops(const Eigen::Ref<const Triangles>& triangles, int num_vertices);
/// Neighbours of each vertex, sorted.
std::vector<std::vector<int>> vertex_neighbours(const Eigen::Ref<const Triangles>& triangles, int num_vertices);

/// Cotangent stiffness matrix, N x N, symmetric positive semi-definite (off-diagonal -(cot a + cot b)/2).
Eigen::SparseMatrix<double> cotangent_laplacian(const Eigen::Ref<const Points>& vertices,
                                                const Eigen::Ref<const Triangles>& triangles);
/// Lumped (barycentric) vertex areas, N.
Eigen::VectorXd vertex_areas(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);

/// What is wrong with a surface as a body skin; empty when it is closed, edge-manifold, vertex-manifold and outward.
std::string closed_surface_defect(const Eigen::Ref<const Points>& vertices,
                                  const Eigen::Ref<const Triangles>& triangles);

/// Angle between the normals of the two triangles of an edge, in (-pi, pi], zero when flat, positive when convex
/// (outward normals). Arguments: edge start, edge end, opposite vertex left, opposite vertex right.
double dihedral_angle(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, const Eigen::Vector3d& left,
                      const Eigen::Vector3d& right);

}  // namespace ndg
