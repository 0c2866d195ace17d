// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"
#include "ndg/elastic/element_sums.h"

namespace ndg {

/// A sum of one energy over elements of one kind. Positions are always those of all vertices, N_v x 3; `places` lists
/// the elements that count. Virtual calls are per term; what a term does with several elements at a time is its own.
/// Functions that add are const and safe to call from several threads.
class EnergyTerm {
public:
    explicit EnergyTerm(Stencils stencils) : stencils_(std::move(stencils)) {}
    virtual ~EnergyTerm() = default;
    EnergyTerm(const EnergyTerm&) = delete;
    EnergyTerm& operator=(const EnergyTerm&) = delete;

    const Stencils& stencils() const { return stencils_; }

    /// The undeformed body. Throws Error for an element that has no sensible rest shape.
    virtual void set_rest(const Eigen::Ref<const Points>& rest_vertices) = 0;

    virtual void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const = 0;
    virtual void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const = 0;
    virtual void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                             HessianSum& sum) const = 0;

protected:
    /// For a term whose elements come and go. Objectives know those that were there when they were made.
    void set_stencils(Stencils stencils) { stencils_ = std::move(stencils); }

private:
    Stencils stencils_;
};

}  // namespace ndg
