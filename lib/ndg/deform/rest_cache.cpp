// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_cache.h"

#include "ndg/core/error.h"

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

void require_pair(const SamplePair& pair, std::size_t num_bodies, std::size_t num_poses)
{
    require_input(pair.body_idx >= 0 && static_cast<std::size_t>(pair.body_idx) < num_bodies,
                  "a sample names body {}, but there are {} bodies", pair.body_idx, num_bodies);
    require_input(pair.pose_idx >= 0 && static_cast<std::size_t>(pair.pose_idx) < num_poses,
                  "a sample names pose {}, but there are {} poses", pair.pose_idx, num_poses);
}

}  // namespace ndg
