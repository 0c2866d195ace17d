// SPDX-License-Identifier: Apache-2.0
// Gradient Skinning (NDG 5.2): the Poisson reconstruction of F_p = R_p.
#pragma once

#include "ndg/deform/deformer.h"
#include "ndg/deform/poisson.h"

namespace ndg {

/// N_v x 3. `poisson` must hold the rest shape of the body.
Points gradient_skinning(const PosedBody& posed, const PoissonReconstruction& poisson);

/// "gradient-skinning".
void register_gradient_skinning(MethodTable& table);

}  // namespace ndg
