// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/elastic_body.h"

#include "ndg/core/error.h"

namespace ndg {

void ElasticBody::add(std::unique_ptr<EnergyTerm> term)
{
    require(term->stencils().num_vertices() == num_vertices_, "the term is for {} vertices, the body has {}",
            term->stencils().num_vertices(), num_vertices_);
    terms_.push_back(std::move(term));
}

void ElasticBody::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    require(rest_vertices.rows() == num_vertices_, "the body has {} volume vertices, the template {}",
            rest_vertices.rows(), num_vertices_);
    for (const auto& term : terms_) term->set_rest(rest_vertices);
}

}  // namespace ndg
