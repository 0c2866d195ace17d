// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/enum_names.h"

#include <string>

namespace ndg {

/// What a part of the anatomy counts as; tendons, ligaments and membranes are muscle.
enum class AnatomyLayer { bone, muscle };
template <>
inline constexpr EnumName<AnatomyLayer> enum_table<AnatomyLayer>[] = {{AnatomyLayer::bone, "bone"},
                                                                      {AnatomyLayer::muscle, "muscle"}};

/// Left is +x.
enum class BodySide { left, right, middle };
template <>
inline constexpr EnumName<BodySide> enum_table<BodySide>[] = {
    {BodySide::left, "left"}, {BodySide::right, "right"}, {BodySide::middle, "middle"}};

/// One bone or muscle: a contiguous range of anatomy vertices and triangles.
struct AnatomyPart {
    std::string name;
    AnatomyLayer layer = AnatomyLayer::bone;
    int vertex_begin = 0, vertex_end = 0, triangle_begin = 0, triangle_end = 0;
    int fma_id = 0;  ///< Foundational Model of Anatomy; 0 for none
    BodySide side = BodySide::middle;
};

}  // namespace ndg
