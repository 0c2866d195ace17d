// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/scene_surface.h"

namespace ndg {

/// Diverging map from blue (-1) over light grey (0) to red (+1), sRGB in [0, 1]; values beyond are clamped.
Eigen::Vector3f diverging_colour(double value);

/// V_deformed / V_rest - 1 of the tissue below each wrap vertex, N_w: both sums run over the prisms of both layers that
/// touch the vertex on any of the three wraps. `num_wrap_vertices` = N_w, vertices have 3 N_w rows. Zero for a vertex
/// that no prism touches.
Eigen::VectorXd volume_change(const Eigen::Ref<const Points>& rest_vertices,
                              const Eigen::Ref<const Points>& deformed_vertices, const Eigen::Ref<const Prisms>& prisms,
                              int num_wrap_vertices);

}  // namespace ndg
