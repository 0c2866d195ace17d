// SPDX-License-Identifier: Apache-2.0
// A template of MakeHuman's skin without layers, and people whom sample-bodies does not draw.
#pragma once

#include "ndg/body/template.h"
#include "ndg/makehuman/makehuman.h"
#include "ndg/scan/skin_places.h"

#include <string>
#include <utility>
#include <vector>

namespace ndg::test {

/// The skin of the template of 15 000 prisms, with 48 examples; without layers, which fits do not need.
Template makehuman_skin_template(const MakeHuman& source, const std::string& folder);

/// A person of given parameters and weights of further shape targets (path without ending).
SkinnedSurface makehuman_person(const MakeHuman& source, const std::string& folder,
                                const MakeHumanParameters& parameters,
                                const std::vector<std::pair<std::string, double>>& targets);

/// Another tessellation of a skin: remeshed to edges of `edge_length` (m), then smoothed.
Points remeshed_and_smoothed(const SkinnedSurface& skin, double edge_length, int smoothing_rounds,
                             Triangles& triangles);

}  // namespace ndg::test
