// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/objective.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <numeric>

namespace ndg {

namespace {

std::vector<int> free_vertices(const ElasticBody& body)
{
    std::vector<int> vertices(body.num_vertices() - body.num_fixed_vertices());
    std::iota(vertices.begin(), vertices.end(), body.num_fixed_vertices());
    return vertices;
}

std::vector<ElementPlaces> places_of(const ElasticBody& body, const std::vector<int>& vertices, bool fixed_may_move)
{
    const int first = fixed_may_move ? 0 : body.num_fixed_vertices();
    require(!vertices.empty() && std::is_sorted(vertices.begin(), vertices.end()) && vertices.front() >= first &&
                vertices.back() < body.num_vertices(),
            "unknown vertices must be ascending and none of the fixed ones");
    std::vector<ElementPlaces> places;
    for (const auto& term : body.terms()) places.emplace_back(term->stencils(), vertices);
    return places;
}

}  // namespace

Objective::Objective(const ElasticBody& body) : Objective(body, free_vertices(body)) {}

Objective::Objective(const ElasticBody& body, std::vector<int> vertices, bool fixed_may_move)
    : body_(body),
      vertices_(std::move(vertices)),
      places_(places_of(body, vertices_, fixed_may_move)),
      pattern_(static_cast<int>(vertices_.size()), places_)
{
    for (ElementPlaces& places : places_) places.find_blocks(pattern_);
}

double Objective::energy(const Points& positions) const
{
    EnergySum sum;
    for (std::size_t t = 0; t < places_.size(); ++t) body_.terms()[t]->add_energy(positions, places_[t], sum);
    return sum.total();
}

void Objective::gradient(const Points& positions, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const
{
    gradient.setZero(num_unknowns());
    absolute.setZero(num_unknowns());
    ForceSum sum(gradient, absolute);
    for (std::size_t t = 0; t < places_.size(); ++t) body_.terms()[t]->add_forces(positions, places_[t], sum);
}

void Objective::hessian(const Points& positions, HessianKind kind, Eigen::SparseMatrix<double>& hessian) const
{
    require(hessian.rows() == num_unknowns() && hessian.nonZeros() == pattern_.num_values(),
            "the matrix given does not have the pattern of this objective");
    std::fill_n(hessian.valuePtr(), hessian.nonZeros(), 0.0);
    HessianSum sum(hessian);
    for (std::size_t t = 0; t < places_.size(); ++t) body_.terms()[t]->add_hessian(positions, places_[t], kind, sum);
}

}  // namespace ndg
