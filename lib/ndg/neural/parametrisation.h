// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): from nine numbers Q a prism to its residual deformation gradient (NDG
// section 4.4).
#pragma once

#include "ndg/neural/options.h"

#include <torch/types.h>

namespace ndg {

/// All give the identity for Q = 0. Matrices are nine numbers, row-major.
struct Parametrisation {
    ParametrisationKind kind;
    /// Residuals of Q, (B, N_p, 9) to the same shape, differentiable.
    torch::Tensor (*residuals)(const torch::Tensor& q);
    /// The same in TorchScript, lines indented by four: from q (count x 9) to f (count x 3 x 3).
    const char* script;
    /// Nearly the Q of one residual, good enough to span a basis and used for nothing else; null where there is none.
    void (*approximate_inverse)(const float* residual, float* q);
};

const Parametrisation& find_parametrisation(ParametrisationKind kind);

/// exp of each 3 x 3 block of a (..., 9) float tensor, differentiable. Our own kernel on the CPU, where
/// torch::matrix_exp takes ten times as long and more; tensor_exponential elsewhere.
torch::Tensor differentiable_exponential(const torch::Tensor& matrices);

}  // namespace ndg
