// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/dataset/sample_index.h"
#include "ndg/body/template.h"
#include "ndg/deform/poisson.h"

#include <optional>

namespace ndg {

/// The Poisson factor of the body used last, so that samples in order of bodies factor each body once.
class RestCache {
public:
    /// Keeps references to both arguments.
    RestCache(const Template& body_template, const BodySet& bodies) : template_(body_template), bodies_(bodies) {}

    /// Valid until the next call. Throws as PoissonReconstruction does.
    const PoissonReconstruction& poisson(int body_idx);

private:
    const Template& template_;
    const BodySet& bodies_;
    std::optional<PoissonReconstruction> poisson_;
    int body_idx_ = -1;
};

}  // namespace ndg
