// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): matrix exponentials in tensor operations, for devices that our own
// kernel (matrix_exponential.h) does not run on.
#pragma once

#include <torch/types.h>

namespace ndg {

/// exp of each 3 x 3 block of a (..., 9) float tensor, differentiable, on the tensor's device. The same scaling, Taylor
/// polynomial and squarings as matrix_exponential's, for all matrices side by side: products are a few operations on
/// large arrays, where torch::matrix_exp takes batches of small products and, for its derivative, matrices of 6 x 6.
torch::Tensor tensor_exponential(const torch::Tensor& matrices);

}  // namespace ndg
