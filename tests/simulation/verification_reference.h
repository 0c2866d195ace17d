// SPDX-License-Identifier: Apache-2.0
// A standard finite element method to hold the prisms against: quadratic tetrahedra with four quadrature points, own
// stress and stiffness, own assembly, Newton's method. It shares with the library only the energy density,
//   psi(F) = mu/2 (|F|^2 - 3) - mu (J - 1) + lambda/2 (J - 1)^2.
#pragma once

#include "ndg/core/types.h"
#include "ndg/elastic/materials.h"

#include <array>
#include <vector>

namespace ndg::test {

struct SolidMesh {
    Points rest, positions;  ///< N x 3
    std::vector<char> held;  ///< N
    RowMatrixI elements;     ///< T x 4; after quadratic() T x 10: corners, then the middles of edges 01 02 03 12 13 23
    std::vector<int> materials;

    int num_nodes() const { return static_cast<int>(rest.rows()); }
    /// Numbers of the new nodes, whose rest, positions and whether held are those of the edges' middles; an edge
    /// between held nodes has a held middle.
    SolidMesh refined() const;
    SolidMesh quadratic() const;
};

/// Three tetrahedra a prism, matching across prisms; prisms from fat_begin on are of material 1, before it 0. Vertices
/// that are not in `free` are held.
SolidMesh split_prisms(const Points& rest, const Points& positions, const Prisms& prisms, int fat_begin,
                       const std::vector<int>& free);

/// J; and d energy / d positions, N x 3 (of held nodes too).
double solid_energy(const SolidMesh& mesh, const std::array<Lame, 2>& lame);
Points solid_forces(const SolidMesh& mesh, const std::array<Lame, 2>& lame);

struct SolidEquilibrium {
    double energy = 0, residual = 0;  ///< J; N, Euclidean norm over the free nodes
    int iterations = 0;
};
/// Moves the free nodes to equilibrium; quadratic meshes only.
SolidEquilibrium solve(SolidMesh& mesh, const std::array<Lame, 2>& lame);

}  // namespace ndg::test
