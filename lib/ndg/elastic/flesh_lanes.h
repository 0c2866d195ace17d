// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/element_batches.h"
#include "ndg/elastic/element_sums.h"

#include <Eigen/Core>

#include <tuple>

namespace ndg {

/// The kernel (lane_term.h) of flesh elements with one deformation gradient F, weight times psi(F): it takes a law to
/// the element's corners. A `Law` has a type Material, a constructor from (columns of F, materials, weight) and, times
/// the weight, energy(), stress() = d psi / d F by columns, stability(), hessian(g, blocks) and projected_hessian(g,
/// blocks), which take d^2 psi / d F^2 to corners by the columns g of the element's gradient operator.
template <class Law, std::size_t Corners>
class FleshLanes {
public:
    static constexpr int num_corners = Corners;
    struct Rest {
        Eigen::Matrix<double, 3, Corners> gradient;  ///< G with F^T = G X, X the corners; its columns sum to zero
        double weight = 0;                           ///< m^3
        typename Law::Material material;
    };
    using Batch = ElementBatch<Rest>;

    FleshLanes(const Points& positions, const Batch& batch)
        : FleshLanes(gather_corners<Corners>(positions, batch.corners), batch.rests)
    {
    }
    /// For corners at `x`.
    FleshLanes(const std::array<Lanes3, Corners>& x, const std::array<const Rest*, num_lanes>& rests)
        : g_(gather_gradients(rests)),
          law_(deformation(x), materials(rests), gather_lanes(rests, [](const Rest* rest) { return rest->weight; }))
    {
    }

    Lanes energy() const { return law_.energy(); }
    Lanes stability() const { return law_.stability(); }
    std::tuple<LaneVector<3 * Corners>> forces() const
    {
        std::tuple<LaneVector<3 * Corners>> result;
        const std::array<Lanes3, 3> stress = law_.stress();
        for (std::size_t a = 0; a < Corners; ++a) {
            std::get<0>(result).set3(a, g_[a][0] * stress[0] + g_[a][1] * stress[1] + g_[a][2] * stress[2]);
        }
        return result;
    }
    void hessian(LaneBlocks<Corners>& blocks) const { law_.hessian(g_, blocks); }
    void semidefinite_hessian(HessianKind, LaneBlocks<Corners>& blocks) const { law_.projected_hessian(g_, blocks); }

private:
    static std::array<Lanes3, Corners> gather_gradients(const std::array<const Rest*, num_lanes>& rests)
    {
        std::array<Lanes3, Corners> g;
        for (std::size_t a = 0; a < Corners; ++a) {
            for (std::size_t c = 0; c < 3; ++c) {
                g[a][c] = gather_lanes(rests, [&](const Rest* rest) { return rest->gradient.data()[3 * a + c]; });
            }
        }
        return g;
    }
    static std::array<const typename Law::Material*, num_lanes> materials(
        const std::array<const Rest*, num_lanes>& rests)
    {
        return {&rests[0]->material, &rests[1]->material, &rests[2]->material, &rests[3]->material};
    }
    std::array<Lanes3, 3> deformation(const std::array<Lanes3, Corners>& x) const
    {
        // The columns of G sum to zero; differences keep the digits that a body's distance from the origin costs.
        constexpr std::size_t last = Corners - 1;
        std::array<Lanes3, last> arms;
        for (std::size_t a = 0; a < last; ++a) arms[a] = x[a] - x[last];
        std::array<Lanes3, 3> f;
        for (std::size_t j = 0; j < 3; ++j) {
            f[j] = g_[0][j] * arms[0];
            for (std::size_t a = 1; a < last; ++a) f[j] = f[j] + g_[a][j] * arms[a];
        }
        return f;
    }

    std::array<Lanes3, Corners> g_;  ///< columns of G
    Law law_;
};

}  // namespace ndg
