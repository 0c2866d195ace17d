// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body_source/template_source.h"
#include "ndg/geometry/distance_grid.h"
#include "ndg/wraps/wrap_skin.h"

#include <vector>

namespace ndg {

struct EnvelopeOptions {
    double spacing = 0.0025;       ///< m, of the grid
    double bone_closing = 0.012;   ///< m, radius of the ball that rolls over all bones
    double neck_closing = 0.4;     ///< m, over the same in front of the spine, from the breastbone up
    double belly_closing = 0.11;   ///< m, likewise below it: so far the bones' envelope dips towards the lumbar spine
    double trunk_closing = 0.08;   ///< m, over spine, ribs, pelvis and shoulder girdle: bridges ribs and pelvis
    double trunk_depth = 0.016;    ///< m under the skin: the envelopes of these larger balls come no nearer
    double pocket_closing = 0.03;  ///< m, over the same: fills what opens to the side, as behind a shoulder blade
    double pocket_depth = 0.007;   ///< m under the skin, likewise
    double bone_dilation = 0.5, muscle_dilation = 0.25;  ///< of the spacing: a grid does not see thinner blades
    double muscle_closing = 0.018;                       ///< m, over muscles and bones
    double bone_depth = 0.0034;                          ///< m under the skin: no envelope of bones comes nearer
    double muscle_depth = 0.0017;                        ///< m, likewise for muscles
    double min_thickness = 0.0008;                       ///< m between the two envelopes
};

/// Signed distances to what the wraps shall enclose, negative inside.
struct WrapEnvelopes {
    ScalarGrid bone, muscle;
    ScalarGrid skin;  ///< signed distance to the skin itself
};

/// Closings of the bones and of muscles and bones, inside of each other and under the skin. Where bones and muscles lie
/// deeper than the depths of `options` they are in their envelopes. Anatomy outside of the skin's bounding box is left
/// out. Throws Error when there is no bone.
WrapEnvelopes wrap_envelopes(const WrapSkin& skin, const std::vector<AnatomyMesh>& anatomy,
                             const EnvelopeOptions& options);

}  // namespace ndg
