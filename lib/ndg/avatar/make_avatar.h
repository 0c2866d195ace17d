// SPDX-License-Identifier: Apache-2.0
// Avatars made of a statistical body. Links TetGen (AGPL): the target ndg::avatar_build, and what makes avatars.
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/avatar/layer_volume.h"
#include "ndg/avatar/soft_tissue_layer.h"
#include "ndg/avatar/statistical_body.h"
#include "ndg/core/options.h"

#include <vector>

namespace ndg {

struct AvatarOptions {
    LayerOptions layer;
    double thickness = 0.03;      ///< m, at all control points
    int control_points = 12;      ///< the paper: 12 first, then 42
    double tetrahedron_edge = 0;  ///< m, about; 0: one and a half times the mean edge of the skin
};
void describe(OptionList& list, AvatarOptions& options);

struct AvatarReport {
    int num_turned = 0, num_lowered = 0, num_thin = 0;  ///< as in SoftTissueLayer
    int num_unfolded = 0;                               ///< vertices at which the thickness asked for had to be lowered
    double largest_stretch =
        0;  ///< largest distance of neighbours' projections along the bones over theirs on the skin
    double mean_thickness = 0, mean_max_thickness = 0;  ///< m, over the inner surface
    TetrahedraQuality quality;
};

/// The avatar of the person with this shape: the layer lies in that person's own skin, so thickness is in true metres.
/// `control_values`: thickness at the control points, C, m; empty: options.thickness at all. Throws InputError where
/// the body does not say which of its triangles have soft tissue (StatisticalBody::soft_triangles).
Avatar make_avatar(const StatisticalBody& body, const Eigen::Ref<const Eigen::VectorXd>& shape,
                   const AvatarOptions& options, const std::vector<double>& control_values, AvatarReport& report);

enum class VolumeChange { same_tetrahedra, new_tetrahedra };
/// Another thickness (W, m, within its bounds; thickness_field). With the same tetrahedra where they bear it
/// (move_inner_surface); otherwise the volume is made anew, and the thickness lowered where the layer would fold.
VolumeChange change_thickness(Avatar& avatar, const std::vector<double>& thickness, const AvatarOptions& options);

}  // namespace ndg
