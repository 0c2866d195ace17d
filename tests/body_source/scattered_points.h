// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <cmath>

namespace ndg::test {

inline Points scattered_points(int count, unsigned seed)
{
    // Low-discrepancy points in [-1, 1]^3: the fractional parts of multiples of irrational numbers.
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double value = (i + 1.0 + 17.0 * seed) * std::sqrt(2.0 + 3.0 * k + k * k);
            points(i, k) = 2.0 * (value - std::floor(value)) - 1.0;
        }
    return points;
}

}  // namespace ndg::test
