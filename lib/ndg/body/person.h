// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ndg {

/// What a skin does not tell about the person in it.
struct Person {
    double sex = 0.5;  ///< 0 female, 1 male; between, the formulas of both are blended
    double age_years = 40.0;
};

}  // namespace ndg
