// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_cache.h"

#include "ndg/body/anatomy.h"

namespace ndg {

void RestCache::set_body(const Body& body)
{
    if (&body == body_) return;
    operators_.reset();
    poisson_is_of_body_ = false;
    anatomy_.reset();
    body_ = &body;
}

const RestOperators& RestCache::operators(const Body& body)
{
    set_body(body);
    if (!operators_) operators_.emplace(template_->prisms, body.volume_vertices);
    return *operators_;
}

const PoissonReconstruction& RestCache::poisson(const Body& body)
{
    const RestOperators& rest = operators(body);
    if (!poisson_) {
        poisson_.emplace(rest, template_->num_wrap_vertices());
    } else if (!poisson_is_of_body_) {
        poisson_->set_rest(rest);
    }
    poisson_is_of_body_ = true;
    return *poisson_;
}

const Points& RestCache::anatomy(const Body& body)
{
    set_body(body);
    if (!anatomy_) anatomy_ = anatomy_at_rest(*template_, body);
    return *anatomy_;
}

}  // namespace ndg
