// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_cache.h"

namespace ndg {

const PoissonReconstruction& RestCache::poisson(int body_idx)
{
    const Points& rest = bodies_.bodies[static_cast<std::size_t>(body_idx)].volume_vertices;
    if (!poisson_) {
        poisson_.emplace(RestOperators(template_.prisms, rest), template_.num_wrap_vertices());
    } else if (body_idx != body_idx_) {
        poisson_->set_rest(RestOperators(template_.prisms, rest));
    }
    body_idx_ = body_idx;
    return *poisson_;
}

}  // namespace ndg
