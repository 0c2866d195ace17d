// SPDX-License-Identifier: Apache-2.0
// A fixed last layer: principal components of the raw outputs that training samples ask for.
#pragma once

#include "ndg/core/types.h"
#include "ndg/neural/augmentation.h"
#include "ndg/neural/body_regions.h"

#include <cstdint>
#include <vector>

namespace ndg {

/// The leading principal axes, about zero (so that zero coefficients still mean the neutral prediction), of
/// OutputSpace::approximate_inverse of all targets and, with `augmentation` (may be null), of as many changed ones. At
/// most options.output_basis rows of outputs, as many as hold options.output_basis_variance, each scaled by the root
/// mean square of its coefficient, so that unit coefficients are typical. One basis, or one of each of `columns`.
std::vector<RowMatrixF> fit_output_bases(const TrainingSet& set, const Augmentation* augmentation,
                                         const OutputSpace& output_space, const std::vector<NetworkColumns>& columns,
                                         const NetworkOptions& options, std::uint64_t seed);

}  // namespace ndg
