// SPDX-License-Identifier: Apache-2.0
// 3 x 3 matrices side by side, one SIMD lane each, and their exponentials. Inlined into functions that are compiled for
// registers of several widths; a lane's numbers are the same in all of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace ndg::matrix_lanes {

/// After scaling, the Frobenius norm is at most `scaled_norm`; the remainder of the Taylor polynomial of this degree is
/// then below the unit round-off (0.5^9/9! = 5e-9 and 0.5^15/15! = 2e-17).
constexpr double scaled_norm = 0.5;
template <typename T>
constexpr int taylor_degree = sizeof(T) == 4 ? 8 : 14;
constexpr int max_squarings = 16;

/// Matrices side by side, one lane each: entry (i, j) of lane l is m[3 i + j][l].
template <typename T>
struct alignas(64) Block {
    static constexpr int lanes = static_cast<int>(64 / sizeof(T));
    T m[9][lanes];
};

template <typename T>
void load(const T* matrices, int used_lanes, Block<T>& block)
{
    for (int lane = 0; lane < Block<T>::lanes; ++lane)
        for (int k = 0; k < 9; ++k) block.m[k][lane] = lane < used_lanes ? matrices[9 * lane + k] : T(0);
}

template <typename T>
void store(const Block<T>& block, int used_lanes, T* matrices)
{
    for (int lane = 0; lane < used_lanes; ++lane)
        for (int k = 0; k < 9; ++k) matrices[9 * lane + k] = block.m[k][lane];
}

/// c = op(a) op(b), op the transpose where asked.
template <bool TransposeA, bool TransposeB, typename T>
void multiply(const Block<T>& a, const Block<T>& b, Block<T>& c)
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const T* a0 = a.m[TransposeA ? i : 3 * i];
            const T* a1 = a.m[TransposeA ? 3 + i : 3 * i + 1];
            const T* a2 = a.m[TransposeA ? 6 + i : 3 * i + 2];
            const T* b0 = b.m[TransposeB ? 3 * j : j];
            const T* b1 = b.m[TransposeB ? 3 * j + 1 : 3 + j];
            const T* b2 = b.m[TransposeB ? 3 * j + 2 : 6 + j];
            T* target = c.m[3 * i + j];
#pragma omp simd
            for (int l = 0; l < Block<T>::lanes; ++l) target[l] = a0[l] * b0[l] + a1[l] * b1[l] + a2[l] * b2[l];
        }
}

template <typename T>
void set_identity(Block<T>& block)
{
    for (int k = 0; k < 9; ++k)
        for (int l = 0; l < Block<T>::lanes; ++l) block.m[k][l] = k % 4 == 0 ? T(1) : T(0);
}

/// Scales each lane's matrix to at most `scaled_norm`: number of squarings and scale of each lane, and the largest
/// number.
template <typename T>
struct Scaling {
    int squarings[Block<T>::lanes];
    T scale[Block<T>::lanes];
    int most = 0;
};

/// Of a number's square, how often its root must be halved until it is at most `scaled_norm`, from the bits of its
/// exponent; 0 for what is not finite.
template <typename T>
int count_squarings(T squared_norm)
{
    using Bits = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
    constexpr int mantissa = std::numeric_limits<T>::digits - 1, bias = std::numeric_limits<T>::max_exponent - 1;
    constexpr int not_finite = 2 * bias + 1, square_of_scaled_norm = -2;  // as a power of two
    Bits bits = 0;
    std::memcpy(&bits, &squared_norm, sizeof(bits));
    const int exponent = static_cast<int>(bits >> mantissa);
    const int halvings = ((exponent - bias - square_of_scaled_norm) >> 1) + 1;
    const int clamped = std::min(std::max(halvings, 0), max_squarings);
    return exponent == not_finite ? 0 : clamped;
}

template <typename T>
Scaling<T> scale_matrices(Block<T>& block)
{
    Scaling<T> scaling;
    T squared_norm[Block<T>::lanes] = {};
    for (int k = 0; k < 9; ++k)
        for (int l = 0; l < Block<T>::lanes; ++l) squared_norm[l] += block.m[k][l] * block.m[k][l];
    for (int l = 0; l < Block<T>::lanes; ++l) {
        scaling.squarings[l] = count_squarings(squared_norm[l]);
        scaling.scale[l] = T(1) / static_cast<T>(1 << scaling.squarings[l]);
        scaling.most = std::max(scaling.most, scaling.squarings[l]);
    }
    for (int k = 0; k < 9; ++k)
        for (int l = 0; l < Block<T>::lanes; ++l) block.m[k][l] *= scaling.scale[l];
    return scaling;
}

/// One step of Horner's rule: p = I + a p / k.
template <typename T>
void horner_step(const Block<T>& a, const Block<T>& p, int k, Block<T>& next)
{
    multiply<false, false>(a, p, next);
    const T factor = T(1) / static_cast<T>(k);
    for (int e = 0; e < 9; ++e)
#pragma omp simd
        for (int l = 0; l < Block<T>::lanes; ++l) next.m[e][l] = next.m[e][l] * factor + (e % 4 == 0 ? T(1) : T(0));
}

/// Takes `candidate` in the lanes that still have to be squared at this level.
template <typename T>
void select(const Scaling<T>& scaling, int level, const Block<T>& candidate, Block<T>& block)
{
    for (int e = 0; e < 9; ++e)
#pragma omp simd
        for (int l = 0; l < Block<T>::lanes; ++l)
            block.m[e][l] = level < scaling.squarings[l] ? candidate.m[e][l] : block.m[e][l];
}

/// a becomes what the polynomial is taken of, p its exponential: scaling and squaring with a Taylor polynomial.
template <typename T>
void exponential(Block<T>& a, Block<T>& p)
{
    Block<T> next;
    const Scaling<T> scaling = scale_matrices(a);
    set_identity(p);
    for (int k = taylor_degree<T>; k >= 1; --k) {
        horner_step(a, p, k, next);
        p = next;
    }
    for (int level = 0; level < scaling.most; ++level) {
        multiply<false, false>(p, p, next);
        select(scaling, level, next, p);
    }
}

// The same code in wider registers is half as long again as fast where there are some.
#ifdef __x86_64__
#define NDG_WIDE_REGISTERS __attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512"), flatten))
inline bool has_wide_registers()
{
    static const bool has =
        __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    return has;
}
#else
#define NDG_WIDE_REGISTERS
inline bool has_wide_registers()
{
    return false;
}
#endif

}  // namespace ndg::matrix_lanes
