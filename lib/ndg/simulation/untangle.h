// SPDX-License-Identifier: Apache-2.0
// Skin that passes through itself is drawn in until it does not: where contact starts.
#pragma once

#include "ndg/body/template.h"

#include <utility>
#include <vector>

namespace ndg {

/// Where skin triangles cross, draws skin and muscle wrap towards the bone wrap along the lines between corresponding
/// vertices, little by little and less around, and evens out what is still crossed when the skin has come to the bones.
/// A connected skin that crosses itself nowhere lies on the right side of itself everywhere, however it got there.
/// Where that is possible, `gap` (m) is left between skin and skin where it was drawn in. Returns the pairs of wrap
/// triangles that cross still: bones that pass through each other may leave no way out.
std::vector<std::pair<int, int>> untangle(Points& volume_vertices, const Template& body_template, double gap);

}  // namespace ndg
