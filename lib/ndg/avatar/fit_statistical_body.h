// SPDX-License-Identifier: Apache-2.0
// A statistical body of ours: of a template, bodies made with it, their shape space and correctives.
#pragma once

#include "ndg/avatar/statistical_body.h"
#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"
#include "ndg/core/options.h"
#include "ndg/deform/linear_correctives.h"

#include <string>
#include <vector>

namespace ndg {

struct StatisticalBodyOptions {
    int shape_directions = 0;       ///< most that are kept; 0: all of the shape space
    double regressor_ridge = 1e-7;  ///< weight of squared regressor entries beside squared positions, m^2
    double pose_fade = 0.05;        ///< m from the cuts over which pose directions grow from zero
};
void describe(OptionList& list, StatisticalBodyOptions& options);

/// Distances of what the statistical body says of a body to the body itself, m.
struct BodyErrors {
    double mean_skin = 0, largest_skin = 0;          ///< skins by shape parameters
    double mean_joint = 0, largest_joint = 0;        ///< joints regressed from the true skins
    double mean_held_out = 0, largest_held_out = 0;  ///< joints of bodies (every fifth) that the regressor did not see
};

/// Regressor of joints from the vertices of skins, K x N: affine (rows sum to one) and local. A joint sees the vertices
/// not further away than twice and a half the nearest (and at least 32); their weights minimise
///   sum over bodies |joint - sum w_i v_i|^2 + ridge * bodies * sum (w_i - 1/m)^2,  sum w_i = 1.
/// `rest`: a skin and joints that say what is near.
JointWeights fit_joint_regressor(const Skin& rest, const std::vector<const Skin*>& skins, double ridge);

/// Shape parameters are the codes of the shape space over their standard deviations; directions are the regression of
/// whole skins (head, hands and toes included) on the codes, shape 0 is the mean. Pose directions are those of the
/// correctives at the skin: they were fitted as offsets at rest before linear blend skinning with the template's
/// weights, which are this body's too, so they fit it as they are; they fade to zero at the cuts and are zero beyond.
/// `correctives` may be null. `fitted`: indices of the bodies to fit to. Throws InputError for none, or for a shape
/// space of another template.
StatisticalBody fit_statistical_body(const Template& body_template, const BodySet& bodies,
                                     const std::vector<int>& fitted, const ShapeSpace& space,
                                     const LinearCorrectives* correctives, const StatisticalBodyOptions& options,
                                     BodyErrors& errors);

}  // namespace ndg
