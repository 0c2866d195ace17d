// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/matrix_exponential.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ndg {
namespace {

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

template <typename T>
Scaling<T> scale_matrices(Block<T>& block)
{
    Scaling<T> scaling;
    T squared_norm[Block<T>::lanes] = {};
    for (int k = 0; k < 9; ++k)
        for (int l = 0; l < Block<T>::lanes; ++l) squared_norm[l] += block.m[k][l] * block.m[k][l];
    for (int l = 0; l < Block<T>::lanes; ++l) {
        const double norm = std::sqrt(static_cast<double>(squared_norm[l]));
        int exponent = 0;
        if (std::isfinite(norm)) std::frexp(norm / scaled_norm, &exponent);
        scaling.squarings[l] = std::clamp(exponent, 0, max_squarings);
        scaling.scale[l] = static_cast<T>(std::ldexp(1.0, -scaling.squarings[l]));
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

template <typename T>
void exponential_block(const T* matrices, int used_lanes, T* exponentials)
{
    Block<T> a, p, next;
    load(matrices, used_lanes, a);
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
    store(p, used_lanes, exponentials);
}

template <typename T>
void adjoint_block(const T* matrices, const T* exponential_gradients, int used_lanes, T* matrix_gradients)
{
    constexpr int degree = taylor_degree<T>;
    Block<T> a, gradient, left, right;
    load(matrices, used_lanes, a);
    load(exponential_gradients, used_lanes, gradient);
    const Scaling<T> scaling = scale_matrices(a);

    Block<T> partial[degree + 1];  // partial[k]: Horner's sum before step k
    set_identity(partial[degree]);
    for (int k = degree; k >= 1; --k) horner_step(a, partial[k], k, partial[k - 1]);
    Block<T> powers[max_squarings + 1];
    powers[0] = partial[0];
    for (int level = 0; level < scaling.most; ++level) {
        multiply<false, false>(powers[level], powers[level], left);
        powers[level + 1] = powers[level];
        select(scaling, level, left, powers[level + 1]);
    }

    for (int level = scaling.most - 1; level >= 0; --level) {  // of x_{i+1} = x_i x_i
        multiply<true, false>(powers[level], gradient, left);
        multiply<false, true>(gradient, powers[level], right);
        for (int e = 0; e < 9; ++e)
            for (int l = 0; l < Block<T>::lanes; ++l) left.m[e][l] += right.m[e][l];
        select(scaling, level, left, gradient);
    }
    Block<T> total = {};
    for (int k = 1; k <= degree; ++k) {  // of p_{k-1} = I + a p_k / k
        multiply<false, true>(gradient, partial[k], right);
        multiply<true, false>(a, gradient, left);
        const T factor = T(1) / static_cast<T>(k);
        for (int e = 0; e < 9; ++e)
#pragma omp simd
            for (int l = 0; l < Block<T>::lanes; ++l) {
                total.m[e][l] += right.m[e][l] * factor;
                gradient.m[e][l] = left.m[e][l] * factor;
            }
    }
    for (int e = 0; e < 9; ++e)
        for (int l = 0; l < Block<T>::lanes; ++l) total.m[e][l] *= scaling.scale[l];
    store(total, used_lanes, matrix_gradients);
}

// The same code in wider registers, half as long again as fast where there are some; a lane's numbers are the same.
#ifdef __x86_64__
#define NDG_WIDE_REGISTERS __attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512"), flatten))
const bool has_wide_registers =
    __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
#define NDG_WIDE_REGISTERS
constexpr bool has_wide_registers = false;
#endif

template <typename T>
NDG_WIDE_REGISTERS void wide_exponential_block(const T* matrices, int used_lanes, T* exponentials)
{
    exponential_block(matrices, used_lanes, exponentials);
}

template <typename T>
NDG_WIDE_REGISTERS void wide_adjoint_block(const T* matrices, const T* exponential_gradients, int used_lanes,
                                           T* matrix_gradients)
{
    adjoint_block(matrices, exponential_gradients, used_lanes, matrix_gradients);
}

/// Calls f(first matrix, number of matrices) for every block of lanes.
template <typename T, typename F>
void for_blocks(std::size_t count, const F& f)
{
    const auto lanes = static_cast<std::size_t>(Block<T>::lanes);
    const auto num_blocks = static_cast<std::int64_t>((count + lanes - 1) / lanes);
#pragma omp parallel for schedule(static)
    for (std::int64_t block = 0; block < num_blocks; ++block) {
        const std::size_t begin = static_cast<std::size_t>(block) * lanes;
        f(begin, static_cast<int>(std::min(lanes, count - begin)));
    }
}

}  // namespace

template <typename T>
void matrix_exponential(const T* matrices, std::size_t count, T* exponentials)
{
    const auto block = has_wide_registers ? wide_exponential_block<T> : exponential_block<T>;
    for_blocks<T>(count, [&](std::size_t begin, int used_lanes) {
        block(matrices + 9 * begin, used_lanes, exponentials + 9 * begin);
    });
}

template <typename T>
void matrix_exponential_adjoint(const T* matrices, const T* exponential_gradients, std::size_t count,
                                T* matrix_gradients)
{
    const auto block = has_wide_registers ? wide_adjoint_block<T> : adjoint_block<T>;
    for_blocks<T>(count, [&](std::size_t begin, int used_lanes) {
        block(matrices + 9 * begin, exponential_gradients + 9 * begin, used_lanes, matrix_gradients + 9 * begin);
    });
}

template void matrix_exponential<float>(const float*, std::size_t, float*);
template void matrix_exponential<double>(const double*, std::size_t, double*);
template void matrix_exponential_adjoint<float>(const float*, const float*, std::size_t, float*);
template void matrix_exponential_adjoint<double>(const double*, const double*, std::size_t, double*);

}  // namespace ndg
