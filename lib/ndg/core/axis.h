// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/enum_names.h"

#include <Eigen/Core>

namespace ndg {

/// A direction along a coordinate axis.
enum class Axis { x, y, z, minus_x, minus_y, minus_z };
template <>
inline constexpr EnumName<Axis> enum_table<Axis>[] = {{Axis::x, "x"},        {Axis::y, "y"},
                                                      {Axis::z, "z"},        {Axis::minus_x, "-x"},
                                                      {Axis::minus_y, "-y"}, {Axis::minus_z, "-z"}};

/// `coordinate` 0 to 2.
inline Axis axis_along(int coordinate, bool negative)
{
    return static_cast<Axis>(coordinate + (negative ? 3 : 0));
}
inline Eigen::Vector3d unit_vector(Axis axis)
{
    const int index = static_cast<int>(axis);
    return (index < 3 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(index % 3);
}

}  // namespace ndg
