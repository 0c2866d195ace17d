// SPDX-License-Identifier: Apache-2.0
// The innermost product of the factorisation, in a kernel chosen when the program runs. Every kernel adds the same
// products in the same order, with fused multiply-add: processors with wider registers give the same numbers, sooner.
#pragma once

#include <cstddef>

namespace ndg {

/// Rows of a tile, and its most columns.
constexpr int tile_rows = 16, tile_columns = 6;

/// product(r, c) = sum_k a(r, k) b(c, k), k < depth, for r < `rows` (<= tile_rows) and c < 3 or 6 columns; column c of
/// the product starts at tile_rows c. a(r, k) = a[r + stride k]; may read a up to row tile_rows.
struct TileProduct {
    const float* a = nullptr;
    const float* b = nullptr;
    std::size_t stride = 0;
    int depth = 0, rows = 0;
    bool narrow = false;  ///< 3 columns
};
using TileKernel = void (*)(const TileProduct& tile, float* product);

/// For every processor that this program runs on.
void multiply_tile(const TileProduct& tile, float* product);
/// With AVX-512; nothing where the processor or the program does not have it.
TileKernel wide_tile_kernel();

}  // namespace ndg
