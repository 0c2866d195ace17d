// SPDX-License-Identifier: Apache-2.0
// A fixed last layer for small data sets: principal components of the training residuals.
#pragma once

#include "ndg/core/types.h"
#include "ndg/neural/training_set.h"

#include <cstdint>

namespace ndg {

/// What `parametrisation` (exponential or direct) would have to be given to produce a residual, 9 numbers row-major:
/// for direct, F - I; for exponential, log(R) + log(S) of the polar decomposition F = R S, with the stretches raised to
/// at least 0.05 so that it exists for inverted prisms too. Equal to log(F) where R and S commute; good enough to span
/// a basis, and not used for anything else.
void residual_logarithm(const float* residual, bool exponential, float* logarithm);

/// The leading principal axes, about zero (so that zero coefficients still mean the identity), of the logarithms of at
/// most 1000 samples, drawn by `seed` where there are more. k x 9 N_p, each row scaled by the root mean square of its
/// coefficient, so that unit coefficients are typical. Rank-deficient sets give fewer rows.
RowMatrixF fit_output_basis(const TrainingSet& set, int num_components, bool exponential, std::uint64_t seed);

}  // namespace ndg
