// SPDX-License-Identifier: Apache-2.0
// Deformation gradients in unposed space: F = grad (P^-1 x), P the skinning of the pose (Romero et al. 2020, 4.2).
#pragma once

#include "ndg/elastic/flesh_term.h"
#include "ndg/elastic/unposed_lanes.h"

#include <vector>

namespace ndg {

/// What of a term changes with the pose.
class UnposedMaps {
public:
    explicit UnposedMaps(int num_vertices);
    virtual ~UnposedMaps() = default;

    /// One map a vertex, from its unposed position to the world; the identity before the first call. Throws Error for
    /// another number, or for a map that is not finite, turns space inside out or cannot be inverted; nothing changes
    /// then.
    void set_world_from_unposed(const std::vector<AffineMap>& world_from_unposed);
    const std::vector<AffineMap>& unposed_from_world() const { return unposed_from_world_; }

private:
    std::vector<AffineMap> unposed_from_world_;  ///< elements point into it
};

/// Inverses, one each. Throws Error naming the vertex whose map is not finite or has a determinant below 1e-4: there
/// skinning has collapsed or turned space inside out.
std::vector<AffineMap> invert_maps(const std::vector<AffineMap>& maps);
/// The vertices moved by a map each.
Points apply_maps(const std::vector<AffineMap>& maps, const Eigen::Ref<const Points>& points);

/// Flesh of a `Law` whose strain is that of unposed positions; positions, forces and Hessian are the world's.
template <class Law, class Element>
class UnposedFleshTerm : public UnposedMaps,
                         public FleshTerm<Law, Element, UnposedLanes<FleshLanes<Law, Element::num_corners>>> {
    using Base = FleshTerm<Law, Element, UnposedLanes<FleshLanes<Law, Element::num_corners>>>;

public:
    static constexpr int num_corners = Element::num_corners;

    /// As FleshTerm. Rest positions are unposed ones.
    UnposedFleshTerm(const Eigen::Ref<const Cells<num_corners>>& cells,
                     const std::vector<typename Law::Material>& materials, double stiffness, int num_vertices)
        : UnposedMaps(num_vertices), Base(cells, materials, stiffness, num_vertices)
    {
        for (int e = 0; e < this->stencils().size(); ++e) {
            for (int a = 0; a < num_corners; ++a) {
                this->rests_[e].unposed_from_world[a] = &unposed_from_world()[this->stencils().corners(e)[a]];
            }
        }
    }
};

}  // namespace ndg
