// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/element_batches.h"
#include "ndg/elastic/energy_term.h"

#include <tuple>
#include <vector>

namespace ndg {

/// An energy whose kernel takes num_lanes elements at a time. What stays for derived classes to do is set_rest(), which
/// fills rests_. A `Kernel` has
///   num_corners; Rest, what it knows of one element beside its corners; a constructor from (positions, batch);
///   energy(): joule;
///   forces(): a tuple of LaneVectors, d energy / d corners in parts whose absolute values count each by itself;
///   hessian(blocks): d^2 energy / d corners^2;
///   semidefinite_hessian(kind, blocks): the same projected, or Gauss-Newton's;
///   stability(): a lower bound of hessian()'s smallest eigenvalue, as a share of the element's stiffness.
template <class Kernel>
class LaneTerm : public EnergyTerm {
public:
    using EnergyTerm::EnergyTerm;

    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override
    {
        static_assert(std::tuple_size_v<decltype(sum.parts)> == num_lanes);
        Lanes total = load_lanes(sum.parts.data());
        for_batches(stencils(), rests_, places, [&](const Batch& batch) {
            Lanes energy = Kernel(positions, batch).energy();
            for (std::size_t i = batch.count; i < num_lanes; ++i) energy[i] = 0;
            total += energy;
        });
        total.copy_to(sum.parts.data(), std::experimental::element_aligned);
    }

    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override
    {
        for_batches(stencils(), rests_, places, [&](const Batch& batch) {
            const auto forces = Kernel(positions, batch).forces();
            for (int i = 0; i < batch.count; ++i) {
                const int* unknown = places.unknown(batch.places[i]);
                std::apply([&](const auto&... part) { (add_lane(part, i, unknown, sum), ...); }, forces);
            }
        });
    }

    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override
    {
        LaneBlocks<Kernel::num_corners> blocks;
        const auto scatter = [&](const Batch& batch, int lane) {
            sum.add<Kernel::num_corners, num_lanes>(places, batch.places[lane], &blocks.values[lane]);
        };
        const auto add_semidefinite = [&](const Batch& batch) {
            Kernel(positions, batch).semidefinite_hessian(kind, blocks);
            for (int i = 0; i < batch.count; ++i) scatter(batch, i);
        };
        if (kind != HessianKind::exact && kind != HessianKind::nearly_exact) {
            for_batches(stencils(), rests_, places, add_semidefinite);
            return;
        }
        std::vector<int> unstable;
        for_batches(stencils(), rests_, places, [&](const Batch& batch) {
            const Kernel kernel(positions, batch);
            kernel.hessian(blocks);
            const Lanes stability = kind == HessianKind::exact ? Lanes(1.0) : kernel.stability();
            for (int i = 0; i < batch.count; ++i) {
                if (stability[i] < -nearly_exact_tolerance) {
                    unstable.push_back(batch.places[i]);
                } else {
                    scatter(batch, i);
                }
            }
        });
        for_batches(
            stencils(), rests_, places, static_cast<int>(unstable.size()), [&](int i) { return unstable[i]; },
            add_semidefinite);
    }

protected:
    std::vector<typename Kernel::Rest> rests_;  ///< of every element

private:
    using Batch = ElementBatch<typename Kernel::Rest>;
    /// Share of an element's stiffness that its smallest eigenvalue may lie below zero and stay, where most stay.
    static constexpr double nearly_exact_tolerance = 0.3;

    template <std::size_t Size>
    static void add_lane(const LaneVector<Size>& forces, int lane, const int* unknown, ForceSum& sum)
    {
        sum.add<Size / 3, num_lanes>(unknown, &forces.values[lane]);
    }
};

}  // namespace ndg
