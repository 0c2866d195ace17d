// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/energy_term.h"
#include "ndg/elastic/volume_guard.h"

#include <array>
#include <vector>

namespace ndg {

/// What keeps prisms and their corners from inverting (volume_guard.h); nothing where they are far from flat.
class VolumeGuardTerm : public EnergyTerm {
public:
    struct Rest {
        double modulus = 0;               ///< k_f lambda, Pa
        double volume = 0;                ///< m^3
        std::array<double, 6> corners{};  ///< det J, m^3
    };

    /// `moduli`: k_f lambda of every prism.
    VolumeGuardTerm(const Eigen::Ref<const Prisms>& prisms, const std::vector<double>& moduli, int num_vertices);

    void set_rest(const Eigen::Ref<const Points>& rest_vertices) override;
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override;

private:
    template <class Work>
    void for_guarded(const Points& positions, const ElementPlaces& places, const Work& work) const;

    std::vector<Rest> rests_;
};

}  // namespace ndg
