// SPDX-License-Identifier: Apache-2.0
// The skin energies of four edges at a time, a kernel (lane_term.h): the formulas of shell.h in closed form.
#pragma once

#include "ndg/elastic/element_batches.h"
#include "ndg/elastic/element_sums.h"
#include "ndg/elastic/shell.h"

#include <array>
#include <tuple>

namespace ndg {

using HingeBlocks = LaneBlocks<4>;

/// What an edge of the skin is at rest; its corners are those of a hinge.
struct SkinEdgeRest {
    double length = 0;             ///< m
    double stretch_stiffness = 0;  ///< k_s, joule
    HingeRest bend;
};

class SkinLanes {
public:
    static constexpr int num_corners = 4;
    using Rest = SkinEdgeRest;

    SkinLanes(const Points& positions, const ElementBatch<SkinEdgeRest>& batch);

    /// Joule, stretching and bending.
    Lanes energy() const;
    /// d energy / d corners, N: of stretching on the edge's two ends, and of bending.
    std::tuple<LaneVector<6>, LaneVector<12>> forces() const;
    /// bend_stability().
    Lanes stability() const;
    /// d^2 energy / d corners^2.
    void hessian(HingeBlocks& blocks) const;
    /// Bending and stretching each with negative eigenvalues set to zero.
    void projected_hessian(HingeBlocks& blocks) const;
    /// The share of the angle's own stiffness alone; stretching with negative eigenvalues set to zero.
    void gauss_newton_hessian(HingeBlocks& blocks) const;
    void semidefinite_hessian(HessianKind kind, HingeBlocks& blocks) const
    {
        if (kind == HessianKind::gauss_newton) return gauss_newton_hessian(blocks);
        projected_hessian(blocks);
    }

private:
    struct Wing {
        Lanes3 area_vector;  ///< normal of twice the triangle's area
        Lanes3 normal, out;  ///< unit: of the triangle, from the edge to the wing vertex across the edge
        Lanes height;
        Lanes3 slope;                  ///< normal / height
        std::array<Lanes, 3> weights;  ///< (1 - t, t, -1) on edge start, end and wing vertex, t the foot on the edge
    };
    Wing make_wing(const Lanes3& arm, double side, const Lanes& rest_area);
    std::array<Lanes3, 4> angle_gradient() const;
    void bend_hessian(HingeBlocks& blocks) const;
    void add_stretch(HingeBlocks& blocks, bool projected) const;
    template <class Replace>
    void replace_fading(HingeBlocks& blocks, const Replace& replace) const;
    Hinge hinge(std::size_t lane) const;

    std::array<const SkinEdgeRest*, num_lanes> rests_;
    std::array<Lanes3, 4> x_;
    Lanes3 edge_, direction_;
    Lanes length_, rest_length_, stretch_stiffness_, bend_weight_;
    std::array<bool, num_lanes> fading_{};  ///< a wing fades: left to shell.h
    bool any_fading_ = false;
    Wing left_, right_;
    Lanes difference_;  ///< angle minus rest angle
};

}  // namespace ndg
