// SPDX-License-Identifier: Apache-2.0
// Meshes of implicit surfaces. Remeshing is CGAL's (GPL): only target ndg::cgal holds this.
#pragma once

#include "ndg/core/types.h"
#include "ndg/geometry/triangle_mesh.h"

#include <functional>
#include <vector>

namespace ndg {

using ScalarField = std::function<double(const Eigen::Vector3d&)>;

/// Coordinates of the planes of a rectilinear grid, ascending, along x, y and z.
struct GridAxes {
    std::vector<double> x, y, z;
};

/// Surface field = 0 by marching tetrahedra on the grid (six tetrahedra a cell): manifold, outward where the field is
/// negative inside, with a border where it leaves the grid. The field must be close to a distance: cells farther than
/// three times their diagonal from the surface by its value are skipped. Deterministic; runs in parallel.
TriangleMesh marching_tetrahedra(const ScalarField& field, const GridAxes& axes);

/// Isotropic remeshing of a surface that may have a border; label k is remeshed to edges of about edge_lengths[k], in
/// order, and the borders between labels stay chains of edges. Border vertices move along the border only.
/// Deterministic. `labels`, one a triangle, receives those of the new triangles.
TriangleMesh remesh_graded(const TriangleMesh& mesh, std::vector<int>& labels, const std::vector<double>& edge_lengths);

}  // namespace ndg
