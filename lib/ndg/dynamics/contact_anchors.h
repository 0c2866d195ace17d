// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/energy_term.h"

#include <vector>

namespace ndg {

/// Springs that draw vertices to given places: how what moves by itself is brought there through what it pushes away.
class ContactAnchors : public EnergyTerm {
public:
    explicit ContactAnchors(int num_vertices) : EnergyTerm(Stencils(1, {}, num_vertices)) {}

    /// `targets`: places of all vertices, N_v x 3; `stiffness`: newton a metre. Objectives made before must not be used
    /// any more.
    void set(const std::vector<int>& vertices, const Points& targets, double stiffness);

    void set_rest(const Eigen::Ref<const Points>&) override {}
    /// 1/2 k |x - target|^2 each.
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override;

private:
    Points targets_;  ///< of every element
    double stiffness_ = 0;
};

}  // namespace ndg
