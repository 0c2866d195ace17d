// SPDX-License-Identifier: Apache-2.0
#include "verification_bodies.h"

#include "ndg/core/random.h"

#include <algorithm>

namespace ndg::test {

int Block::num_wrap() const
{
    return std::max(points_per_plane(), (points_per_plane() * cells(2) + 1) / 2);
}

int Block::vertex(int i, int j, int k) const
{
    return num_wrap() - points_per_plane() + points_per_plane() * k + i * (cells(1) + 1) + j;
}

std::vector<int> Block::free_vertices() const
{
    std::vector<int> vertices;
    for (int v = vertex(0, 0, 1); v <= vertex(cells(0), cells(1), cells(2)); ++v) vertices.push_back(v);
    return vertices;
}

Template Block::body() const
{
    Template block;
    block.rest.volume_vertices.setZero(3 * num_wrap(), 3);
    for (int v = 0; v < num_wrap(); ++v) block.wrap_to_skin.push_back(v);
    Random random(9, "verification-block");
    for (int i = 0; i <= cells(0); ++i) {
        for (int j = 0; j <= cells(1); ++j) {
            Eigen::Vector2d off(random.uniform(-1, 1), random.uniform(-1, 1));
            if (i == 0 || i == cells(0) || j == 0 || j == cells(1)) off.setZero();
            off *= unevenness;
            for (int k = 0; k <= cells(2); ++k) {
                block.rest.volume_vertices.row(vertex(i, j, k)) << size(0) * (i + off(0)) / cells(0),
                    size(1) * (j + off(1)) / cells(1), size(2) * k / cells(2);
            }
        }
    }
    const int num_squares = cells(0) * cells(1);
    block.prisms.resize(2 * num_squares * cells(2), 6);
    Eigen::Index row = 0;
    for (int k = 0; k < cells(2); ++k) {
        const auto add = [&](int a, int b, int c) {
            const int up = points_per_plane();
            block.prisms.row(row++) << a + up, b + up, c + up, a, b, c;
        };
        for (int i = 0; i < cells(0); ++i) {
            for (int j = 0; j < cells(1); ++j) {
                const int a = vertex(i, j, k), b = vertex(i + 1, j, k);
                add(a, b, b + 1);
                add(a, b + 1, a + 1);
            }
        }
    }
    block.wrap_triangles.resize(0, 3);
    if (cells(2) == 2) block.wrap_triangles = block.prisms.block(0, 3, 2 * num_squares, 3);
    return block;
}

MaterialOptions bare_flesh(double young_muscle_pascal, double young_fat_pascal, double poisson_ratio)
{
    MaterialOptions material;
    material.young_muscle_pascal = young_muscle_pascal;
    material.young_fat_pascal = young_fat_pascal;
    material.poisson_ratio = poisson_ratio;
    material.stretch_stiffness = 0;
    material.bend_stiffness = 0;
    return material;
}

}  // namespace ndg::test
