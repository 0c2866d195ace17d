// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/matrix_exponential.h"

#include "ndg/geometry/matrix_lanes.h"

#include <algorithm>
#include <cstdint>

namespace ndg {
namespace {

using namespace matrix_lanes;

template <typename T>
void exponential_block(const T* matrices, int used_lanes, T* exponentials)
{
    Block<T> a, p;
    load(matrices, used_lanes, a);
    exponential(a, p);
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
    const auto block = has_wide_registers() ? wide_exponential_block<T> : exponential_block<T>;
    for_blocks<T>(count, [&](std::size_t begin, int used_lanes) {
        block(matrices + 9 * begin, used_lanes, exponentials + 9 * begin);
    });
}

template <typename T>
void matrix_exponential_adjoint(const T* matrices, const T* exponential_gradients, std::size_t count,
                                T* matrix_gradients)
{
    const auto block = has_wide_registers() ? wide_adjoint_block<T> : adjoint_block<T>;
    for_blocks<T>(count, [&](std::size_t begin, int used_lanes) {
        block(matrices + 9 * begin, exponential_gradients + 9 * begin, used_lanes, matrix_gradients + 9 * begin);
    });
}

template void matrix_exponential<float>(const float*, std::size_t, float*);
template void matrix_exponential<double>(const double*, std::size_t, double*);
template void matrix_exponential_adjoint<float>(const float*, const float*, std::size_t, float*);
template void matrix_exponential_adjoint<double>(const double*, const double*, std::size_t, double*);

}  // namespace ndg
