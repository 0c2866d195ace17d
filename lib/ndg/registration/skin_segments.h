// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scan/skin_places.h"

#include <string>
#include <vector>

namespace ndg {

/// Regions of the skin by which fits are judged, by the joint that moves a vertex most.
enum class SkinSegment {
    head,
    chest,
    belly,
    hips,
    left_upper_arm,
    right_upper_arm,
    left_forearm,
    right_forearm,
    left_hand,
    right_hand,
    left_thigh,
    right_thigh,
    left_shin,
    right_shin,
    left_foot,
    right_foot
};
inline constexpr int num_skin_segments = 16;
/// "head", "left hand"...
const std::string& segment_name(SkinSegment segment);
/// Segment of each vertex.
std::vector<SkinSegment> skin_segments(const SkinningWeights& weights);

/// What is dressed alike: segments without their side. The scalp is a part of the head (scalp_vertices).
enum class SegmentPair { head, chest, belly, hips, upper_arms, forearms, hands, thighs, shins, feet, scalp };
inline constexpr int num_segment_pairs = 11;
SegmentPair pair_of(SkinSegment segment);

/// 1 for vertices of the head where hair grows: above the forehead, and behind down to the nape. `skin`: at rest.
std::vector<char> scalp_vertices(const SkinnedSurface& skin);

}  // namespace ndg
