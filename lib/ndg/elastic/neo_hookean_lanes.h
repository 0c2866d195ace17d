// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/lanes.h"
#include "ndg/elastic/materials.h"

#include <array>

namespace ndg {

/// The law of neo_hookean.h (a Law of flesh_lanes.h) for four states at a time, on elements of 4 or 6 corners. `g`:
/// columns of the elements' gradient operators.
class NeoHookeanLanes {
public:
    using Material = Lame;

    /// f: columns of F.
    NeoHookeanLanes(const std::array<Lanes3, 3>& f, const std::array<const Lame*, num_lanes>& materials,
                    const Lanes& weight);

    /// weight psi(F).
    Lanes energy() const;
    /// Columns of weight d psi / d F.
    std::array<Lanes3, 3> stress() const;
    /// neo_hookean_stability().
    Lanes stability() const;
    /// weight d^2 psi / d corners^2.
    template <std::size_t Corners>
    void hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const;
    /// The same with the negative eigenvalues of d^2 psi / d F^2 set to zero.
    template <std::size_t Corners>
    void projected_hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const;

private:
    template <std::size_t Corners>
    void remove_negative(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks,
                         const std::array<Lanes3, 3>& u, const std::array<Lanes3, 3>& v, const Lanes3& s) const;
    template <std::size_t Corners>
    void replace_lane(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks, std::size_t lane) const;

    std::array<Lanes3, 3> f_, cofactor_;
    Lanes weight_, mu_, lambda_, dilation_, distortion_, pressure_;
};

}  // namespace ndg
