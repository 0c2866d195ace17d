// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/parametric_surface.h"

namespace ndg {

double stature(const Eigen::Ref<const Points>& vertices)
{
    return vertices.col(1).maxCoeff() - vertices.col(1).minCoeff();
}

}  // namespace ndg
