// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/dense_panels.h"

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
static_assert(2 * packet_size <= static_cast<int>(dense_panel_padding));
/// Columns of a tile; unknowns come in threes.
constexpr int wide = 6, narrow = 3;

constexpr std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

Packet load(const float* values)
{
    return Packet(values, std::experimental::element_aligned);
}

/// Products of a tile of Packets x packet_size rows and Width columns, column by column.
template <int Packets, int Width>
void multiply_tile(const DenseUpdate& update, int row, int column, float* product)
{
    std::array<Packet, at(Packets * Width)> sums;
    for (Packet& sum : sums) sum = 0.0F;
    const float* a = update.a + row;
    const float* b = update.a + column;
    for (int k = 0; k < update.depth; ++k, a += update.stride, b += update.stride) {
        std::array<Packet, at(Packets)> left;
        for (int p = 0; p < Packets; ++p) left[at(p)] = load(a + p * packet_size);
        for (int w = 0; w < Width; ++w) {
            const Packet right = b[w];
            for (int p = 0; p < Packets; ++p) sums[at(p + Packets * w)] += left[at(p)] * right;
        }
    }
    for (int i = 0; i < Packets * Width; ++i) {
        sums[at(i)].copy_to(product + i * packet_size, std::experimental::element_aligned);
    }
}

/// subtract(product, stride, row, column, rows, columns) for every tile that is not above the diagonal.
template <class Subtract>
void for_tiles(const DenseUpdate& update, const Subtract& subtract)
{
    std::array<float, at(2 * packet_size * wide)> product;
    for (int row = 0; row < update.height; row += 2 * packet_size) {
        const int rows = std::min(2 * packet_size, update.height - row);
        const bool half = rows <= packet_size;
        for (int column = 0; column < std::min(update.width, row + rows);) {
            const bool thin = update.width - column <= narrow;
            const int columns = std::min(thin ? narrow : wide, update.width - column);
            if (half && thin) multiply_tile<1, narrow>(update, row, column, product.data());
            if (half && !thin) multiply_tile<1, wide>(update, row, column, product.data());
            if (!half && thin) multiply_tile<2, narrow>(update, row, column, product.data());
            if (!half && !thin) multiply_tile<2, wide>(update, row, column, product.data());
            subtract(product.data(), half ? packet_size : 2 * packet_size, row, column, rows, columns);
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
    for_tiles(update, [&](const float* product, int stride, int row, int column, int rows, int columns) {
        const int* place = target_row + row;
        const bool contiguous = place[rows - 1] - place[0] == rows - 1;
        for (int j = 0; j < columns; ++j) {
            float* to = target + target_stride * at(target_row[column + j]);
            const float* from = product + j * stride;
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
    for_tiles(update, [&](const float* product, int stride, int row, int column, int rows, int columns) {
        for (int j = 0; j < columns; ++j) {
            float* to = target + target_stride * at(column + j) + row;
            const float* from = product + j * stride;
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
