// SPDX-License-Identifier: Apache-2.0
// The skin energies of four edges at a time: the formulas of shell.h in closed form.
#pragma once

#include "ndg/elastic/elastic_model.h"
#include "ndg/elastic/lanes.h"

#include <array>

namespace ndg {

using HingeBlocks = LaneBlocks<4>;

class SkinLanes {
public:
    /// The same element may be given more than once.
    SkinLanes(const Points& positions, const std::array<const SkinElement*, num_lanes>& elements,
              double stretch_stiffness);

    /// Joule, stretching and bending.
    Lanes energy() const;
    /// d energy / d vertices of bending, N, 12 rows; that of stretching is pull() on the edge's end, minus it on its
    /// start.
    void bend_forces(LaneVector<12>& forces) const;
    Lanes3 pull() const;
    /// bend_stability().
    Lanes stability() const;
    /// d^2 energy / d vertices^2.
    void hessian(HingeBlocks& blocks) const;
    /// Bending and stretching each with negative eigenvalues set to zero.
    void projected_hessian(HingeBlocks& blocks) const;
    /// The share of the angle's own stiffness alone; stretching with negative eigenvalues set to zero.
    void gauss_newton_hessian(HingeBlocks& blocks) const;

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

    std::array<const SkinElement*, num_lanes> elements_;
    double stretch_stiffness_;
    std::array<Lanes3, 4> x_;
    Lanes3 edge_, direction_;
    Lanes length_, rest_length_, bend_weight_;
    std::array<bool, num_lanes> fading_{};  ///< a wing fades: left to shell.h
    bool any_fading_ = false;
    Wing left_, right_;
    Lanes difference_;  ///< angle minus rest angle
};

}  // namespace ndg
