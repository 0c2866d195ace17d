// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/colour.h"

#include <algorithm>
#include <cmath>

namespace ndg {

float srgb_from_linear(float value)
{
    const float v = std::clamp(value, 0.0f, 1.0f);
    return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
}

float linear_from_srgb(float value)
{
    const float v = std::clamp(value, 0.0f, 1.0f);
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

Eigen::Vector3f linear_from_srgb(const Eigen::Vector3f& colour)
{
    return {linear_from_srgb(colour[0]), linear_from_srgb(colour[1]), linear_from_srgb(colour[2])};
}

}  // namespace ndg
