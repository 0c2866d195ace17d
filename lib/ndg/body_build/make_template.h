// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/body_source/parametric_surface.h"

namespace ndg {

struct TemplateOptions {
    double target_edge_length = 0.032;  ///< m, of the volumetric skin
    double keep_ratio = 0.25;           ///< share of the source's triangles kept on head, hands and toes
    double fat_share = 0.35;            ///< of the soft tissue of the template body between skin and bone wrap
    double min_scaled_jacobian = 0.08;  ///< prisms flatter than this are improved

    /// Throws InputError for values outside their ranges.
    void check() const;
};

/// The layered template of a parametric surface: skin cut and remeshed, wraps, prisms, bone interior, skinning weights,
/// bone shafts embedded. `weights`: N x J dense weights of the surface's vertices.
/// Throws InputError for an open or inverted surface, Error when no valid layers are found.
Template make_template(const ParametricSurface& surface, const Eigen::Ref<const RowMatrix>& weights,
                       const TemplateOptions& options);

}  // namespace ndg
