// SPDX-License-Identifier: Apache-2.0
// What the rest shape of a body gives its prisms: the way from deformed vertices to deformation gradients (NDG eq. 8).
#pragma once

#include "ndg/core/types.h"
#include "ndg/deform/residuals.h"
#include "ndg/geometry/prism.h"

#include <vector>

namespace ndg {

/// Gradient operators G_p and volumes V_p of one body's prisms, computed once a body. Constant afterwards, so several
/// threads may use one.
class RestOperators {
public:
    /// `rest_vertices`: N_v x 3. Keeps a reference to `prisms`, the template's. Throws Error naming a prism that is
    /// flat or has no positive volume.
    RestOperators(const Prisms& prisms, const Eigen::Ref<const Points>& rest_vertices);

    const Prisms& prisms() const { return *prisms_; }
    int num_prisms() const { return int(gradients_.size()); }
    int num_vertices() const { return num_vertices_; }
    /// G_p: F_p^T = G_p times the six deformed vertices.
    const PrismGradient& gradient(int prism_idx) const { return gradients_[prism_idx]; }
    /// V_p, m^3.
    double volume(int prism_idx) const { return volumes_[prism_idx]; }

    /// F_p of deformed vertices (N_v x 3), N_p x 9. For vertices as stored: computed in double, rounded once.
    Gradients deformation_gradients(const Eigen::Ref<const Points>& vertices) const;
    GradientsF deformation_gradients(const Eigen::Ref<const PointsF>& vertices) const;

    /// R_p^T F_p of deformed vertices (NDG equation 12), N_p x 9, likewise. Throws Error when there is not one rotation
    /// a prism.
    Gradients residuals(const Eigen::Ref<const Points>& vertices,
                        const std::vector<Eigen::Matrix3d>& prism_rotations) const;
    GradientsF residuals(const Eigen::Ref<const PointsF>& vertices,
                         const std::vector<Eigen::Matrix3d>& prism_rotations) const;

private:
    const Prisms* prisms_;
    int num_vertices_;
    std::vector<PrismGradient> gradients_;
    std::vector<double> volumes_;
};

}  // namespace ndg
