// SPDX-License-Identifier: Apache-2.0
// Layers near their targets with prisms of good quality.
#pragma once

#include "ndg/core/options.h"
#include "ndg/core/types.h"

namespace ndg {

/// Three surfaces of one tessellation, N_w x 3 each.
struct LayerSurfaces {
    Points bone, muscle, skin;
};

/// Energies are without unit: lengths count in `length_scale`.
struct LayerFitOptions {
    double min_scaled_jacobian = 0.08;  ///< wanted of every prism at its corners and quadrature points
    double min_thickness = 0.0008;      ///< m, wanted of either layer at the corners
    double length_scale = 0.01;         ///< m
    double skin_spring = 8.0;           ///< holds skin vertices to their targets
    double wrap_spring = 0.5;           ///< holds the vertices of the wraps
    double smoothness = 4.0;            ///< of the Laplacian of the displacements, all three surfaces
    int max_rounds = 14;                ///< in each the weight of prisms that are not good enough grows
};
void describe(OptionList& list, LayerFitOptions& options);

struct LayerFitReport {
    double min_scaled_jacobian = 0;  ///< reached, over both layers
    int worst_triangle = -1;         ///< where
    int moved_vertices = 0;          ///< vertices of the skin's tessellation whose column was free to move
    int rounds = 0;
    double mean_skin_displacement = 0;  ///< m, over all vertices
    double max_skin_displacement = 0;   ///< m
};

/// Minimises over all three surfaces, the skin's vertices included (NDG 4.1),
///   sum of springs to the targets + |umbrella Laplacian of the displacements|^2 + weight * prism_penalty,
/// by a Gauss-Newton method with line search. Away from prisms that are not good enough the targets are the minimum, so
/// that only neighbourhoods of these are free; they and the weights grow from round to round until all prisms are as
/// wanted or nothing helps. `targets` may hold invalid prisms.
LayerSurfaces fit_layers(const Eigen::Ref<const Triangles>& triangles, const LayerSurfaces& targets,
                         const LayerFitOptions& options, LayerFitReport& report);

}  // namespace ndg
