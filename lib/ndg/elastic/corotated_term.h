// SPDX-License-Identifier: Apache-2.0
// Co-rotated linear elasticity of prisms (NDG equations 22 and 23, after Capell et al. 2005): rotations are given, one
// a vertex, so that the energy is quadratic in the positions.
#pragma once

#include "ndg/elastic/lane_term.h"
#include "ndg/elastic/materials.h"
#include "ndg/geometry/prism.h"

#include <array>
#include <tuple>
#include <vector>

namespace ndg {

/// The kernel (lane_term.h) of a prism with the mean over its corners v of
///   psi_v = lambda / 2 tr(eps)^2 + mu tr(eps^2),  eps = (A + A^T) / 2 - I,  A = R_v^T F,
/// times its weight.
class CorotatedLanes {
public:
    static constexpr int num_corners = 6;
    struct Rest {
        PrismGradient gradient;  ///< G with F^T = G X
        double weight = 0;       ///< m^3
        Lame material;
        std::array<const Eigen::Matrix3d*, num_corners> rotations;
    };
    using Batch = ElementBatch<Rest>;

    CorotatedLanes(const Points& positions, const Batch& batch);

    Lanes energy() const;
    std::tuple<LaneVector<3 * num_corners>> forces() const;
    void hessian(LaneBlocks<num_corners>& blocks) const;
    /// The Hessian is semidefinite.
    void semidefinite_hessian(HessianKind, LaneBlocks<num_corners>& blocks) const { hessian(blocks); }
    Lanes stability() const { return 0.0; }

private:
    /// Columns of a 3 x 3 matrix.
    using LaneMatrix = std::array<Lanes3, 3>;
    LaneMatrix rotation(std::size_t corner) const;
    /// eps of one corner; symmetric.
    LaneMatrix strain(const LaneMatrix& rotation) const;

    const Batch& batch_;
    std::array<Lanes3, num_corners> g_;  ///< columns of G
    LaneMatrix f_;
    Lanes weight_, mu_, lambda_;  ///< weight: a corner's share
};

class CorotatedTerm : public LaneTerm<CorotatedLanes> {
public:
    /// `materials`: of every prism. All rotations are the identity.
    CorotatedTerm(const Prisms& prisms, const std::vector<Lame>& materials, int num_vertices);

    /// Throws Error for a flat or inverted prism.
    void set_rest(const Eigen::Ref<const Points>& rest_vertices) override;
    /// R_v of every vertex, world_from_rest. Throws Error for another number.
    void set_rotations(const std::vector<Eigen::Matrix3d>& rotations);

private:
    std::vector<Eigen::Matrix3d> rotations_;
};

}  // namespace ndg
