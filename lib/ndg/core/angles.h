// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace ndg {

constexpr double radians_per_degree = M_PI / 180.0;

}  // namespace ndg
