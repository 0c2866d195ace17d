// SPDX-License-Identifier: Apache-2.0
// Exponentials of many 3 x 3 matrices (NDG equation 15) and their exact derivative.
// Scaling and squaring with a Taylor polynomial, one SIMD lane a matrix, OpenMP over blocks of lanes. The result of a
// matrix depends on that matrix alone: neither on its neighbours nor on the number of threads.
#pragma once

#include <cstddef>

namespace ndg {

/// exponentials[i] = exp(matrices[i]); both `count` x 9, row-major. Frobenius norms up to 3e4; the result overflows to
/// infinity where the exact one does. Non-finite matrices give non-finite results.
template <typename T>
void matrix_exponential(const T* matrices, std::size_t count, T* exponentials);

/// Reverse-mode derivative: matrix_gradients[i] = dL/dmatrices[i] for exponential_gradients[i] = dL/dexp(matrices[i]).
/// It is the Frechet derivative of exp at the transposed matrix, computed by reversing the polynomial and the
/// squarings.
template <typename T>
void matrix_exponential_adjoint(const T* matrices, const T* exponential_gradients, std::size_t count,
                                T* matrix_gradients);

extern template void matrix_exponential<float>(const float*, std::size_t, float*);
extern template void matrix_exponential<double>(const double*, std::size_t, double*);
extern template void matrix_exponential_adjoint<float>(const float*, const float*, std::size_t, float*);
extern template void matrix_exponential_adjoint<double>(const double*, const double*, std::size_t, double*);

}  // namespace ndg
