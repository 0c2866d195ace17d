// SPDX-License-Identifier: Apache-2.0
// Boxes of right prisms for the tests that hold the finite elements against other answers. Only what layered_body()
// needs of a template is filled.
#pragma once

#include "ndg/body/template.h"
#include "ndg/elastic/materials.h"

#include <vector>

namespace ndg::test {

/// cells(0) x cells(1) squares of two triangles each, in cells(2) layers of prisms; cells(2) is even, the lower half of
/// the layers is muscle, the upper half fat. With two layers it is a body's slab of flesh: bone wrap at z = 0, muscle
/// wrap, skin on top.
struct Block {
    Eigen::Array3i cells{4, 4, 2};
    Eigen::Vector3d size{0.1, 0.1, 0.03};  ///< m
    /// Points inside every plane lie off the regular grid by up to this share of a cell, the same in all planes.
    double unevenness = 0;

    int points_per_plane() const { return (cells(0) + 1) * (cells(1) + 1); }
    /// A template's first third of vertices is given and it has three times as many: with more than two layers, the
    /// first vertices belong to no prism.
    int num_wrap() const;
    /// Volume vertex of grid point (i, j) in plane k.
    int vertex(int i, int j, int k) const;
    /// Above z = 0, ascending.
    std::vector<int> free_vertices() const;
    Template body() const;
};

/// Flesh without skin.
MaterialOptions bare_flesh(double young_muscle_pascal, double young_fat_pascal, double poisson_ratio);

}  // namespace ndg::test
