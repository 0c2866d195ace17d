// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <functional>

namespace ndg {

struct MinimiseOptions {
    int max_iterations = 200;
    double max_move = 0.01;   ///< m, of a point in one iteration
    double tolerance = 1e-3;  ///< ends when ten iterations lower the objective by less than this share
};

struct MinimiseResult {
    int iterations = 0, evaluations = 0;
    double objective = 0.0;
};

/// Minimises over points by L-BFGS (Nocedal and Wright 2006, algorithm 7.5) with a positive definite preconditioner as
/// initial inverse Hessian and backtracking from full steps. `limit(points, move)` may shorten a move where it would
/// leave what is allowed. `objective(points, gradient)` may be infinite: such points are never accepted, so what it
/// forbids never happens. `points` must start where it is finite; throws Error if not.
MinimiseResult minimise(const std::function<double(const Points&, Points&)>& objective,
                        const std::function<Points(const Points&)>& precondition,
                        const std::function<void(const Points&, Points&)>& limit, const MinimiseOptions& options,
                        Points& points);

}  // namespace ndg
