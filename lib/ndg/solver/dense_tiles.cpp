// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/dense_tiles.h"

#include <array>
#include <experimental/simd>

// Without fused multiply-add in the rest of the program the sums would differ.
#if defined(__x86_64__) && defined(__FMA__)
#define NDG_WIDE_TILES
#include <immintrin.h>
#endif

namespace ndg {

namespace {

/// As wide on every machine, so that sums are the same on every machine.
constexpr int packet_size = 8;
using Packet = std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, packet_size>>;

template <int Packets, int Width>
void multiply(const TileProduct& tile, float* product)
{
    std::array<Packet, Packets * Width> sums;
    for (Packet& sum : sums) sum = 0.0F;
    const float* a = tile.a;
    const float* b = tile.b;
    for (int k = 0; k < tile.depth; ++k, a += tile.stride, b += tile.stride) {
        std::array<Packet, Packets> left;
        for (int p = 0; p < Packets; ++p) left[p] = Packet(a + p * packet_size, std::experimental::element_aligned);
        for (int w = 0; w < Width; ++w) {
            const Packet right = b[w];
            for (int p = 0; p < Packets; ++p) sums[p + Packets * w] += left[p] * right;
        }
    }
    for (int w = 0; w < Width; ++w) {
        for (int p = 0; p < Packets; ++p) {
            sums[p + Packets * w].copy_to(product + tile_rows * w + packet_size * p,
                                          std::experimental::element_aligned);
        }
    }
}

#ifdef NDG_WIDE_TILES
template <int Width>
__attribute__((target("avx512f"))) void multiply_wide(const TileProduct& tile, float* product)
{
    __m512 sums[Width];
    for (__m512& sum : sums) sum = _mm512_setzero_ps();
    const float* a = tile.a;
    const float* b = tile.b;
    for (int k = 0; k < tile.depth; ++k, a += tile.stride, b += tile.stride) {
        const __m512 left = _mm512_loadu_ps(a);
        for (int w = 0; w < Width; ++w) sums[w] = _mm512_fmadd_ps(left, _mm512_set1_ps(b[w]), sums[w]);
    }
    for (int w = 0; w < Width; ++w) _mm512_storeu_ps(product + tile_rows * w, sums[w]);
}

void multiply_wide_tile(const TileProduct& tile, float* product)
{
    tile.narrow ? multiply_wide<tile_columns / 2>(tile, product) : multiply_wide<tile_columns>(tile, product);
}
#endif

}  // namespace

void multiply_tile(const TileProduct& tile, float* product)
{
    constexpr int narrow = tile_columns / 2;
    if (tile.rows <= packet_size) {
        tile.narrow ? multiply<1, narrow>(tile, product) : multiply<1, tile_columns>(tile, product);
    } else {
        tile.narrow ? multiply<2, narrow>(tile, product) : multiply<2, tile_columns>(tile, product);
    }
}

TileKernel wide_tile_kernel()
{
#ifdef NDG_WIDE_TILES
    if (__builtin_cpu_supports("avx512f")) return multiply_wide_tile;
#endif
    return nullptr;
}

}  // namespace ndg
