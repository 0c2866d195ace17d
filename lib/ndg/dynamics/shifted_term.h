// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/energy_term.h"

namespace ndg {

/// A term of some vertices among more: those of `inner` are the ones from `first` on.
class ShiftedTerm : public EnergyTerm {
public:
    /// Keeps a reference to `inner`, whose elements must stay and whose rest shape is for its owner to set.
    ShiftedTerm(const EnergyTerm& inner, int first, int num_vertices);

    void set_rest(const Eigen::Ref<const Points>&) override {}
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override;

private:
    Points own(const Points& positions) const;

    const EnergyTerm& inner_;
    int first_;
};

}  // namespace ndg
