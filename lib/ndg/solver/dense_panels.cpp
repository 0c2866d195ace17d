// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/dense_panels.h"

#include "ndg/solver/dense_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <experimental/simd>
#include <type_traits>

namespace ndg {

namespace {

/// As wide on every machine, so that sums are the same on every machine.
constexpr int packet_size = 8;
using Packet = std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, packet_size>>;
static_assert(tile_rows <= static_cast<int>(dense_panel_padding));
/// Columns of a tile; unknowns come in threes.
constexpr int wide = tile_columns, narrow = tile_columns / 2;

constexpr std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

Packet load(const float* values)
{
    return Packet(values, std::experimental::element_aligned);
}

/// subtract(product, row, column, rows, columns) for every tile that is not above the diagonal.
template <class Subtract>
void for_tiles(const DenseUpdate& update, const Subtract& subtract)
{
    static const TileKernel wide_kernel = wide_tile_kernel();
    static const TileKernel multiply = wide_kernel != nullptr ? wide_kernel : multiply_tile;
    std::array<float, at(tile_rows * wide)> product;
    TileProduct tile;
    tile.stride = update.stride;
    tile.depth = update.depth;
    for (int row = 0; row < update.height; row += tile_rows) {
        tile.rows = std::min(tile_rows, update.height - row);
        tile.a = update.a + row;
        for (int column = 0; column < std::min(update.width, row + tile.rows);) {
            tile.narrow = update.width - column <= narrow;
            tile.b = update.a + column;
            const int columns = std::min(tile.narrow ? narrow : wide, update.width - column);
            multiply(tile, product.data());
            subtract(product.data(), row, column, tile.rows, columns);
            column += columns;
        }
    }
}

/// One step of a substitution, for `Width` columns of a block from its diagonal on; x holds its rows.
template <int Width>
void forward_step(const float* columns, std::size_t stride, int rows, float* x)
{
    std::array<Packet, at(Width)> solved;
    for (int k = 0; k < Width; ++k) {
        x[k] /= columns[at(k) * stride + at(k)];
        for (int i = k + 1; i < Width; ++i) x[i] -= columns[at(k) * stride + at(i)] * x[k];
        solved[at(k)] = x[k];
    }
    int i = Width;
    for (; i + packet_size <= rows; i += packet_size) {
        Packet sum = solved[0] * load(columns + i);
        for (int k = 1; k < Width; ++k) sum += solved[at(k)] * load(columns + at(k) * stride + at(i));
        (load(x + i) - sum).copy_to(x + i, std::experimental::element_aligned);
    }
    for (; i < rows; ++i) {
        for (int k = 0; k < Width; ++k) x[i] -= columns[at(k) * stride + at(i)] * x[k];
    }
}

template <int Width>
void backward_step(const float* columns, std::size_t stride, int rows, float* x)
{
    std::array<Packet, at(Width)> sums;
    for (Packet& sum : sums) sum = 0.0F;
    int i = Width;
    for (; i + packet_size <= rows; i += packet_size) {
        const Packet below = load(x + i);
        for (int k = 0; k < Width; ++k) sums[at(k)] += load(columns + at(k) * stride + at(i)) * below;
    }
    for (int k = Width - 1; k >= 0; --k) {
        const float* column = columns + at(k) * stride;
        float sum = reduce(sums[at(k)]);
        for (int j = i; j < rows; ++j) sum += column[j] * x[j];
        for (int j = k + 1; j < Width; ++j) sum += column[j] * x[j];
        x[k] = (x[k] - sum) / column[k];
    }
}

/// Columns that a substitution takes at a time, so that every pass over x serves many.
constexpr int step_columns = 8;

/// The rows below a factored square of `width` columns, packet by packet.
template <class Value>
void solve_rows(float* columns, std::size_t stride, int width, const std::array<float, at(wide* wide)>& factor, int row)
{
    constexpr bool scalar = std::is_same<Value, float>::value;
    std::array<Value, at(wide)> x;
    for (int j = 0; j < width; ++j) {
        float* place = columns + at(j) * stride + at(row);
        if constexpr (scalar) {
            x[at(j)] = *place;
        } else {
            x[at(j)] = load(place);
        }
        for (int k = 0; k < j; ++k) x[at(j)] -= factor[at(j + wide * k)] * x[at(k)];
        x[at(j)] *= factor[at(j + wide * j)];
        if constexpr (scalar) {
            *place = x[at(j)];
        } else {
            x[at(j)].copy_to(place, std::experimental::element_aligned);
        }
    }
}

}  // namespace

void subtract_scattered(const DenseUpdate& update, float* target, std::size_t target_stride, const int* target_row)
{
    for_tiles(update, [&](const float* product, int row, int column, int rows, int columns) {
        const int* place = target_row + row;
        const bool contiguous = place[rows - 1] - place[0] == rows - 1;
        for (int j = 0; j < columns; ++j) {
            float* to = target + target_stride * at(target_row[column + j]);
            const float* from = product + j * tile_rows;
            if (contiguous) {
                to += place[0];
                for (int i = 0; i < rows; ++i) to[i] -= from[i];
            } else {
                for (int i = 0; i < rows; ++i) to[place[i]] -= from[i];
            }
        }
    });
}

void subtract_contiguous(const DenseUpdate& update, float* target, std::size_t target_stride)
{
    for_tiles(update, [&](const float* product, int row, int column, int rows, int columns) {
        for (int j = 0; j < columns; ++j) {
            float* to = target + target_stride * at(column + j) + row;
            const float* from = product + j * tile_rows;
            for (int i = 0; i < rows; ++i) to[i] -= from[i];
        }
    });
}

bool factorize_panel(float* block, int columns, int rows)
{
    const std::size_t stride = at(rows);
    for (int begin = 0; begin < columns; begin += wide) {
        const int width = std::min(wide, columns - begin);
        float* diagonal = block + at(begin) * stride + at(begin);
        if (begin > 0) {
            DenseUpdate update;
            update.a = block + begin;
            update.stride = stride;
            update.depth = begin;
            update.height = rows - begin;
            update.width = width;
            subtract_contiguous(update, diagonal, stride);
        }
        std::array<float, at(wide * wide)> factor{};  // with inverse diagonal
        for (int j = 0; j < width; ++j) {
            for (int i = j; i < width; ++i) {
                float value = diagonal[at(j) * stride + at(i)];
                for (int k = 0; k < j; ++k) {
                    value -= diagonal[at(k) * stride + at(i)] * diagonal[at(k) * stride + at(j)];
                }
                if (i == j) {
                    if (!(value > 0)) return false;
                    value = std::sqrt(value);
                    factor[at(j + wide * j)] = 1 / value;
                } else {
                    value *= factor[at(j + wide * j)];
                    factor[at(i + wide * j)] = value;
                }
                diagonal[at(j) * stride + at(i)] = value;
            }
        }
        int row = width;
        const int below = rows - begin;
        for (; row + packet_size <= below; row += packet_size) solve_rows<Packet>(diagonal, stride, width, factor, row);
        for (; row < below; ++row) solve_rows<float>(diagonal, stride, width, factor, row);
    }
    return true;
}

void substitute_forward(const float* block, int columns, int rows, float* x)
{
    const std::size_t stride = at(rows);
    const auto diagonal = [&](int j) { return block + at(j) * (stride + 1); };
    int j = 0;
    for (; j + step_columns <= columns; j += step_columns) {
        forward_step<step_columns>(diagonal(j), stride, rows - j, x + j);
    }
    for (; j + narrow <= columns; j += narrow) forward_step<narrow>(diagonal(j), stride, rows - j, x + j);
    for (; j < columns; ++j) forward_step<1>(diagonal(j), stride, rows - j, x + j);
}

void substitute_backward(const float* block, int columns, int rows, float* x)
{
    const std::size_t stride = at(rows);
    const auto diagonal = [&](int j) { return block + at(j) * (stride + 1); };
    int j = columns;
    while (j > 0) {
        const int left = j % step_columns;
        const int width = left == 0 ? step_columns : left % narrow == 0 ? narrow : 1;
        j -= width;
        if (width == step_columns) backward_step<step_columns>(diagonal(j), stride, rows - j, x + j);
        if (width == narrow) backward_step<narrow>(diagonal(j), stride, rows - j, x + j);
        if (width == 1) backward_step<1>(diagonal(j), stride, rows - j, x + j);
    }
}

}  // namespace ndg
