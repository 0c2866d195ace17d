// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/error.h"
#include "ndg/elastic/elements.h"
#include "ndg/elastic/flesh_lanes.h"
#include "ndg/elastic/lane_term.h"

#include <vector>

namespace ndg {

template <int Corners>
using Cells = Eigen::Matrix<int, Eigen::Dynamic, Corners, Eigen::RowMajor>;

/// Flesh of a `Law` (flesh_lanes.h) on elements of one kind (elements.h), NDG equations 2 and 3. `Kernel`: what takes
/// positions to the law.
template <class Law, class Element, class Kernel = FleshLanes<Law, Element::num_corners>>
class FleshTerm : public LaneTerm<Kernel> {
public:
    static constexpr int num_corners = Element::num_corners;

    /// `materials`: of every cell. An element weighs `stiffness` (k_f) times its rest volume.
    FleshTerm(const Eigen::Ref<const Cells<num_corners>>& cells, const std::vector<typename Law::Material>& materials,
              double stiffness, int num_vertices)
        : LaneTerm<Kernel>(
              Stencils(num_corners, std::vector<int>(cells.data(), cells.data() + cells.size()), num_vertices)),
          stiffness_(stiffness)
    {
        this->rests_.resize(materials.size());
        for (std::size_t e = 0; e < materials.size(); ++e) this->rests_[e].material = materials[e];
        require(this->stencils().size() == static_cast<int>(materials.size()), "{} cells of {} materials",
                this->stencils().size(), materials.size());
    }

    /// Throws Error for a flat or inverted element.
    void set_rest(const Eigen::Ref<const Points>& rest_vertices) override
    {
        for (int e = 0; e < this->stencils().size(); ++e) {
            const auto corners = corner_positions<num_corners>(rest_vertices, this->stencils().corners(e));
            const double volume = Element::volume(corners);
            require(volume > 0, "rest {} {} has volume {} m^3", Element::name, e, volume);
            this->rests_[e].gradient = Element::gradient_operator(corners);
            this->rests_[e].weight = stiffness_ * volume;
        }
    }

private:
    double stiffness_;
};

}  // namespace ndg
