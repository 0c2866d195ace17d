// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): products of batches with a layer's matrix. On the CPU by oneDNN, whose
// kernels are made for the processor at run time; the float32 products of Debian's libtorch are those of OpenBLAS.
// A libtorch with CUDA brings a oneDNN of its own, beside which no other may be linked: there, products are libtorch's.
#pragma once

#include <torch/types.h>

namespace ndg {

/// a (m x k) times b (k x n), to float32 and with float32 sums. Both float32 or both bfloat16, on one device; either
/// may be a transposed view. On all OpenMP threads, or on the calling one inside a parallel region. Not differentiable.
torch::Tensor product(const torch::Tensor& a, const torch::Tensor& b);
/// The same of tensors on the CPU into `result`, m x n row-major, or added to what stands there.
enum class Into { replace, add };
void product(const torch::Tensor& a, const torch::Tensor& b, float* result, Into into = Into::replace);

}  // namespace ndg
