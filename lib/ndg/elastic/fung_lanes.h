// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/lanes.h"
#include "ndg/elastic/orthotropic_material.h"

#include <array>

namespace ndg {

/// The law of orthotropic_material.h (a Law of flesh_lanes.h) for four states at a time, on elements of 4 or 6 corners.
/// `g`: columns of the elements' gradient operators. Where eta sigma passes largest_exponent, or is not a number, the
/// energy is infinite, and forces and Hessian are those of the bound.
class FungLanes {
public:
    using Material = OrthotropicMaterial;

    /// f: columns of F.
    FungLanes(const std::array<Lanes3, 3>& f, const std::array<const OrthotropicMaterial*, num_lanes>& materials,
              const Lanes& weight);

    /// weight psi(F).
    Lanes energy() const;
    /// Columns of weight d psi / d F.
    std::array<Lanes3, 3> stress() const;
    /// A lower bound of the smallest eigenvalue of d^2 psi / d F^2, over mu exp(eta sigma): what pressure and stress
    /// take from a Hessian that is positive semi-definite without them.
    Lanes stability() const;
    /// weight d^2 psi / d corners^2.
    template <std::size_t Corners>
    void hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const;
    /// The same with the negative eigenvalues of d^2 psi / d F^2 set to zero.
    template <std::size_t Corners>
    void projected_hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const;

private:
    /// For g in the material's basis.
    template <std::size_t Corners>
    void hessian_in_basis(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const;
    template <std::size_t Corners>
    std::array<Lanes3, Corners> in_basis(const std::array<Lanes3, Corners>& g) const;

    std::array<Lanes3, 3> basis_;                        ///< columns of B
    std::array<Lanes3, 3> f_, cofactor_;                 ///< columns of F B and of its cofactor matrix
    std::array<std::array<Lanes, 3>, 3> tau_, tension_;  ///< tension: d sigma / d E', 2 tau_ij E'_ij
    Lanes weight_, mu_, lambda_, saturation_, exponent_, growth_, dilation_;  ///< growth: mu exp(eta sigma)
};

}  // namespace ndg
