// SPDX-License-Identifier: Apache-2.0
// Where the inner surface of the soft tissue can lie (Romero et al. 2020, 3.2).
#pragma once

#include "ndg/avatar/joint_weights.h"
#include "ndg/avatar/skeleton_projection.h"
#include "ndg/avatar/soft_region.h"
#include "ndg/core/options.h"

#include <vector>

namespace ndg {

struct LayerOptions {
    double min_thickness = 0.005;   ///< m; the paper's h_min
    double bone_radius = 0.015;     ///< m; the paper's b: the inner surface stays as far from the projections
    double rim_thickness = 0.004;   ///< m, at the rims
    double rim_fade = 0.08;         ///< m from the rims over which bounds grow to their own
    double smoothing_length = 0.1;  ///< m, of ProjectionOptions
    double max_slope = 1.0;         ///< most that the upper bound changes along an edge, over its length
};
void describe(OptionList& list, LayerOptions& options);

/// W each, rows as in the region. Every thickness field between the bounds that changes along edges by no more than
/// `max_slope` is meant to be possible; that no element is inverted is checked for each.
struct SoftTissueLayer {
    std::vector<SkeletonPoint> projections;
    Points inward;                      ///< W x 3, unit, towards the projections
    std::vector<double> min_thickness;  ///< m
    std::vector<double> max_thickness;  ///< m
    int num_turned = 0;                 ///< directions that leaned too far from the normal and were turned towards it
    int num_lowered = 0;  ///< upper bounds lowered because the inner surface would fold or cross itself there
    int num_thin = 0;     ///< places where bone lies no deeper than the least thickness
};

/// `outer`: W x 3, the skin of the region at rest. Throws InputError where the skin crosses itself, and where even the
/// least thickness folds the inner surface over.
SoftTissueLayer soft_tissue_layer(const Eigen::Ref<const Points>& outer, const SoftRegion& region,
                                  const SkeletonTree& tree, const LayerOptions& options);

/// Joints that move some vertex of the region by a tenth or more: the bones that begin at them lie in its flesh.
std::vector<bool> flesh_joints(const SoftRegion& region, const JointWeights& weights);

/// Triangles of the region whose prism is turned inside out somewhere, or of which the layer's surface crosses itself.
std::vector<int> folded_triangles(const SoftRegion& region, const Eigen::Ref<const Points>& outer,
                                  const Eigen::Ref<const Points>& inward, const std::vector<double>& thickness);

/// Lowers a thickness field towards `least`, where triangles are folded, until none is. Returns how many vertices it
/// lowered. Throws InputError naming the place where that does not help.
int unfold_thickness(const SoftRegion& region, const Eigen::Ref<const Points>& outer,
                     const Eigen::Ref<const Points>& inward, const std::vector<double>& least, double max_slope,
                     std::vector<double>& thickness);

}  // namespace ndg
