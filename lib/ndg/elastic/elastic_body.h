// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/energy_term.h"

#include <memory>
#include <vector>

namespace ndg {

/// The energy terms of a body and which of its vertices may move. Made once; set_rest() changes the body. What is
/// unknown and how it is assembled: objective.h.
class ElasticBody {
public:
    /// The first `num_fixed` of the vertices are given.
    ElasticBody(int num_vertices, int num_fixed) : num_vertices_(num_vertices), num_fixed_(num_fixed) {}

    /// Sums are over the terms in the order they are added. Objectives made before do not know the term.
    void add(std::unique_ptr<EnergyTerm> term);
    /// Throws Error for another number of vertices, or as a term does.
    void set_rest(const Eigen::Ref<const Points>& rest_vertices);

    int num_vertices() const { return num_vertices_; }
    int num_fixed_vertices() const { return num_fixed_; }
    const std::vector<std::unique_ptr<EnergyTerm>>& terms() const { return terms_; }

private:
    int num_vertices_, num_fixed_;
    std::vector<std::unique_ptr<EnergyTerm>> terms_;
};

}  // namespace ndg
