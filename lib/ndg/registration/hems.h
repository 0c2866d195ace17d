// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/articulated_fit.h"
#include "ndg/registration/skin_segments.h"
#include "ndg/scan/skin_places.h"

#include <array>
#include <vector>

namespace ndg {

/// What clothes on the limbs hide.
struct HemCover {
    std::array<bool, num_segment_pairs> dressed{};
    std::vector<char> covered;  ///< N, on the limbs; what of the trunk is covered is left open
};

/// Finds where trousers, skirts, sleeves, stockings and gloves end: skin is smooth along a limb, and a hem is a step
/// all around it, whatever the girth of the limb. The scan's distance outside `posed` (N x 3, the likeliest person
/// where the scan is) is compared between the 3 cm before and behind every place along upper and lower limb, in eight
/// sectors around the bone; a hem steps the same way by at least 7 mm in three quarters of them, on both sides of the
/// body. The thicker side is dressed: towards the trunk trousers, shorts or sleeves, with hips or chest and belly; away
/// from it stockings or gloves. `rest`: that person at rest.
/// Without `arms` sleeves are not looked for: the posed skin of raised arms is too far off.
HemCover find_hems(const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed, const ScanTarget& scan,
                   bool arms);

}  // namespace ndg
