// SPDX-License-Identifier: Apache-2.0
// The dense work of a supernodal factorisation in single precision. Supernodes of an elastic body are narrow (18
// columns in the mean), and a general BLAS spends half its time there on packing, on calls and on the way back to the
// target.
#pragma once

#include <cstddef>

namespace ndg {

/// Kernels read up to so many values past the last row of a column: what holds the blocks must be so much longer.
constexpr std::size_t dense_panel_padding = 16;

/// target(r, c) -= sum_k a(r, k) a(c, k) for r < height, c < width, at least where row r is not above row c of the
/// target; a(r, k) = a[r + stride k], k < depth. Row r, column c of the target is
/// target[target_row[r] + target_stride * target_row[c]].
struct DenseUpdate {
    const float* a = nullptr;
    std::size_t stride = 0;
    int depth = 0, height = 0, width = 0;
};
void subtract_scattered(const DenseUpdate& update, float* target, std::size_t target_stride, const int* target_row);
/// The same where target_row[r] = r.
void subtract_contiguous(const DenseUpdate& update, float* target, std::size_t target_stride);

/// Factors the first `columns` columns of a block with `rows` rows, column by column: its upper square becomes the
/// lower Cholesky factor L, what is below is multiplied by L^-T. False where the square is not positive definite.
bool factorize_panel(float* block, int columns, int rows);

/// x of `rows` values: solves L y = x for the first `columns` and subtracts from the rest what those contribute.
void substitute_forward(const float* block, int columns, int rows, float* x);
/// Solves L^T y = x for the first `columns` with the rest known.
void substitute_backward(const float* block, int columns, int rows, float* x);

}  // namespace ndg
