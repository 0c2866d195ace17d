// SPDX-License-Identifier: Apache-2.0
// Residual deformation gradients as what a network predicts (NDG sections 4.3 and 4.4).
#pragma once

#include "ndg/neural/output_space.h"

namespace ndg {

/// R_p^T F_p of every prism, N_p x 9 row-major; neutral: the identity, that is, Gradient Skinning. Activation:
/// options.parametrisation. Without options.rotation the root's rotation stands for every R_p, so that predictions
/// still turn with the root, which the network does not see.
std::unique_ptr<OutputSpace> make_prism_residuals(const Template& body_template, const NetworkOptions& options);

}  // namespace ndg
