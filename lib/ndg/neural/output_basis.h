// SPDX-License-Identifier: Apache-2.0
// A fixed last layer for small data sets: principal components of the raw outputs that training samples ask for.
#pragma once

#include "ndg/core/types.h"
#include "ndg/neural/output_space.h"
#include "ndg/neural/training_set.h"

#include <cstdint>

namespace ndg {

/// The leading principal axes, about zero (so that zero coefficients still mean the neutral prediction), of
/// OutputSpace::approximate_inverse of at most 1000 targets, drawn by `seed` where there are more. k x outputs, each
/// row scaled by the root mean square of its coefficient, so that unit coefficients are typical. Rank-deficient sets
/// give fewer rows.
RowMatrixF fit_output_basis(const TrainingSet& set, const OutputSpace& output_space, int num_components,
                            std::uint64_t seed);

}  // namespace ndg
