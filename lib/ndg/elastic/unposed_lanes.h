// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/element_batches.h"
#include "ndg/elastic/element_sums.h"
#include "ndg/geometry/affine_map.h"

#include <tuple>

namespace ndg {

/// The kernel (lane_term.h) of an energy of unposed positions as a function of world positions (Romero et al. 2020,
/// section 4.2): of every corner, u = K x + s, with a map of its own. `Inner`: a kernel of one part of forces that is
/// made of corners and rests, as FleshLanes is. Forces are K^T f, blocks of the Hessian K_a^T H_ab K_b.
template <class Inner>
class UnposedLanes {
public:
    static constexpr int num_corners = Inner::num_corners;
    struct Rest : Inner::Rest {
        std::array<const AffineMap*, num_corners> unposed_from_world;  ///< (K, s) of every corner
    };
    using Batch = ElementBatch<Rest>;

    UnposedLanes(const Points& positions, const Batch& batch)
        : k_(gather_linear(batch)), inner_(unposed(positions, batch), inner_rests(batch))
    {
    }

    Lanes energy() const { return inner_.energy(); }
    /// That of the energy by unposed positions.
    Lanes stability() const { return inner_.stability(); }
    std::tuple<LaneVector<3 * num_corners>> forces() const
    {
        auto result = inner_.forces();
        auto& forces = std::get<0>(result);
        for (std::size_t a = 0; a < count; ++a) {
            const Lanes3 force{{forces.get(3 * a), forces.get(3 * a + 1), forces.get(3 * a + 2)}};
            forces.set3(a, {{dot(k_[a][0], force), dot(k_[a][1], force), dot(k_[a][2], force)}});
        }
        return result;
    }
    void hessian(LaneBlocks<num_corners>& blocks) const
    {
        inner_.hessian(blocks);
        carry_back(blocks);
    }
    void semidefinite_hessian(HessianKind kind, LaneBlocks<num_corners>& blocks) const
    {
        inner_.semidefinite_hessian(kind, blocks);
        carry_back(blocks);
    }

private:
    static constexpr auto count = static_cast<std::size_t>(num_corners);
    /// Columns of K, a corner each.
    using LinearParts = std::array<std::array<Lanes3, 3>, count>;

    static Lanes3 gather_column(const Batch& batch, std::size_t corner, std::size_t column)
    {
        Lanes3 result;
        for (std::size_t r = 0; r < 3; ++r) {
            result[r] = gather_lanes(batch.rests, [&](const Rest* rest) {
                return rest->unposed_from_world[corner]->data()[3 * column + r];
            });
        }
        return result;
    }
    static LinearParts gather_linear(const Batch& batch)
    {
        LinearParts k;
        for (std::size_t a = 0; a < count; ++a) {
            for (std::size_t c = 0; c < 3; ++c) k[a][c] = gather_column(batch, a, c);
        }
        return k;
    }
    static std::array<const typename Inner::Rest*, num_lanes> inner_rests(const Batch& batch)
    {
        return {batch.rests[0], batch.rests[1], batch.rests[2], batch.rests[3]};
    }
    std::array<Lanes3, count> unposed(const Points& positions, const Batch& batch) const
    {
        std::array<Lanes3, count> x = gather_corners<count>(positions, batch.corners);
        for (std::size_t a = 0; a < count; ++a) {
            x[a] = x[a][0] * k_[a][0] + x[a][1] * k_[a][1] + x[a][2] * k_[a][2] + gather_column(batch, a, 3);
        }
        return x;
    }
    void carry_back(LaneBlocks<num_corners>& blocks) const
    {
        for (std::size_t a = 0; a < count; ++a) {
            for (std::size_t b = 0; b <= a; ++b) {
                const std::size_t at = LaneBlocks<count>::at(a, b);
                std::array<Lanes3, 3> right;  // columns of H_ab K_b
                for (std::size_t c = 0; c < 3; ++c) {
                    for (std::size_t r = 0; r < 3; ++r) {
                        right[c][r] = blocks.get(at + r) * k_[b][c][0] + blocks.get(at + 3 + r) * k_[b][c][1] +
                                      blocks.get(at + 6 + r) * k_[b][c][2];
                    }
                }
                for (std::size_t c = 0; c < 3; ++c) {
                    for (std::size_t r = 0; r < 3; ++r) blocks.set(at + r + 3 * c, dot(k_[a][r], right[c]));
                }
            }
        }
    }

    LinearParts k_;
    Inner inner_;
};

}  // namespace ndg
