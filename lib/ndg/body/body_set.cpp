// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/geometry/prism.h"

#include <algorithm>

namespace ndg {

PrismCheck check_prisms(const Eigen::Ref<const Points>& volume_vertices, const Eigen::Ref<const Prisms>& prisms)
{
    Eigen::VectorXd jacobians(prisms.rows()), scaled_jacobians(prisms.rows());
#pragma omp parallel for schedule(static)
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        const PrismVertices prism = gather_prism(volume_vertices, prisms, p);
        jacobians[p] = prism_min_jacobian(prism);
        scaled_jacobians[p] = prism_min_scaled_jacobian(prism);
    }
    PrismCheck check;
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        if (check.worst_prism_idx < 0 || jacobians[p] < check.min_jacobian) {
            check.min_jacobian = jacobians[p];
            check.worst_prism_idx = static_cast<int>(p);
        }
        check.min_scaled_jacobian =
            p == 0 ? scaled_jacobians[p] : std::min(check.min_scaled_jacobian, scaled_jacobians[p]);
        // Written so that a Jacobian that is not a number counts as invalid.
        if (!(jacobians[p] > 0.0)) ++check.num_invalid;
    }
    return check;
}

}  // namespace ndg
