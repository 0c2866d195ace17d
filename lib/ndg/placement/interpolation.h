// SPDX-License-Identifier: Apache-2.0
// Functions of one variable given at knots.
#pragma once

#include <vector>

namespace ndg {

/// Piecewise linear, constant beyond the ends. `knots` ascend.
double interpolate(const std::vector<double>& knots, const std::vector<double>& values, double x);

/// Monotone cubic through all knots (slopes are harmonic means; Fritsch and Butland 1984), straight on beyond the ends.
double interpolate_monotone(const std::vector<double>& knots, const std::vector<double>& values, double x);

/// 0 up to `begin`, 1 from `end` on, cubic between.
double smoothstep(double begin, double end, double x);

}  // namespace ndg
