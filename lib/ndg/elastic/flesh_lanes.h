// SPDX-License-Identifier: Apache-2.0
// The flesh energy of four prisms at a time: the formulas of neo_hookean.h, taken to the prism's vertices.
#pragma once

#include "ndg/elastic/elastic_model.h"
#include "ndg/elastic/lanes.h"

#include <array>

namespace ndg {

using PrismBlocks = LaneBlocks<6>;

class FleshLanes {
public:
    /// The same element may be given more than once.
    FleshLanes(const Points& positions, const std::array<const FleshElement*, num_lanes>& elements);

    /// Joule.
    Lanes energy() const;
    /// d energy / d vertices, N, 18 rows.
    void forces(LaneVector<18>& forces) const;
    /// Volumes over rest volumes, exact (supplement equation 15).
    Lanes volume_shares() const;
    /// neo_hookean_stability().
    Lanes stability() const;
    /// d^2 energy / d vertices^2.
    void hessian(PrismBlocks& blocks) const;
    /// The same with the negative eigenvalues of d^2 psi / d F^2 set to zero.
    void projected_hessian(PrismBlocks& blocks) const;

private:
    void remove_negative(PrismBlocks& blocks, const std::array<Lanes3, 3>& u, const std::array<Lanes3, 3>& v,
                         const Lanes3& s) const;
    void replace_lane(PrismBlocks& blocks, std::size_t lane) const;

    std::array<const FleshElement*, num_lanes> elements_;
    std::array<Lanes3, 6> x_, g_;  ///< vertices; columns of G_p
    std::array<Lanes3, 3> f_;      ///< columns of F
    std::array<Lanes3, 3> cofactor_;
    Lanes weight_, mu_, lambda_, rest_volume_, dilation_, distortion_, pressure_;
};

}  // namespace ndg
