// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/enum_names.h"

namespace ndg {

enum class Sex { male, female };
template <>
inline constexpr EnumName<Sex> enum_table<Sex>[] = {{Sex::male, "male"}, {Sex::female, "female"}};

/// What a skin does not tell about the person in it.
struct Person {
    double sex = 0.5;  ///< 0 female, 1 male; between, the formulas of both are blended
    double age_years = 40.0;
};
/// Person::sex.
constexpr double male_share(Sex sex)
{
    return sex == Sex::male ? 1.0 : 0.0;
}

}  // namespace ndg
