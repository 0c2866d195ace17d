// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/shifted_term.h"

namespace ndg {

namespace {

Stencils shifted(const Stencils& stencils, int first, int num_vertices)
{
    std::vector<int> corners;
    for (int e = 0; e < stencils.size(); ++e) {
        for (int a = 0; a < stencils.num_corners(); ++a) corners.push_back(first + stencils.corners(e)[a]);
    }
    // Corners that no cell has in common stay so.
    std::vector<std::pair<int, int>> apart;
    for (int a = 0; a < stencils.num_corners(); ++a) {
        for (int b = a + 1; b < stencils.num_corners(); ++b) {
            if (!stencils.adjacent(a, b)) apart.emplace_back(a, b);
        }
    }
    return Stencils(stencils.num_corners(), std::move(corners), num_vertices, std::move(apart));
}

}  // namespace

ShiftedTerm::ShiftedTerm(const EnergyTerm& inner, int first, int num_vertices)
    : EnergyTerm(shifted(inner.stencils(), first, num_vertices)), inner_(inner), first_(first)
{
}

/// Elements know their corners by the inner term's numbers; where entries go stands in the places.
Points ShiftedTerm::own(const Points& positions) const
{
    return positions.middleRows(first_, inner_.stencils().num_vertices());
}

void ShiftedTerm::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    inner_.add_energy(own(positions), places, sum);
}

void ShiftedTerm::add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const
{
    inner_.add_forces(own(positions), places, sum);
}

void ShiftedTerm::add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                              HessianSum& sum) const
{
    inner_.add_hessian(own(positions), places, kind, sum);
}

}  // namespace ndg
