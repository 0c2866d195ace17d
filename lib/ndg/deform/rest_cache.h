// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/deform/poisson.h"
#include "ndg/deform/rest_operators.h"

#include <optional>

namespace ndg {

/// What the rest shape of a body alone determines, each made when first asked for and kept until another body is asked
/// for: samples in order of bodies need each once. Bodies are told apart by their address.
class RestCache {
public:
    /// Keeps a reference to `body_template`.
    explicit RestCache(const Template& body_template) : template_(&body_template) {}

    const RestOperators& operators(const Body& body);
    /// Throws as PoissonReconstruction does. The symbolic analysis is made once.
    const PoissonReconstruction& poisson(const Body& body);
    /// anatomy_at_rest, N_a x 3.
    const Points& anatomy(const Body& body);

private:
    void set_body(const Body& body);

    const Template* template_;
    const Body* body_ = nullptr;
    std::optional<RestOperators> operators_;
    std::optional<PoissonReconstruction> poisson_;
    bool poisson_is_of_body_ = false;
    std::optional<Points> anatomy_;
};

}  // namespace ndg
