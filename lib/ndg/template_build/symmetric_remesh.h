// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"
#include "ndg/template_build/region_cut.h"

#include <memory>
#include <vector>

namespace ndg {

struct RemeshedSkin {
    Points vertices;           ///< on the input surface
    Triangles triangles;       ///< closed, outward, mirror image of itself in x = 0
    std::vector<int> regions;  ///< T, indices into skin_region_names (region_cut.h)
    std::vector<int> mirror;   ///< N, vertex at the mirrored place (itself on x = 0)

    /// Triangles of the volumetric region; the template has two prisms for each.
    int num_body_triangles() const;
};

/// Remeshes a (nearly) symmetric closed skin to any resolution: its left half, cut at x = 0, is remeshed and mirrored.
/// Where the source is a little asymmetric, vertices of the right half are put onto the source's right half and lie
/// that much off the mirrored place. Made once for a source, used for each resolution.
class SymmetricRemesher {
public:
    /// `weights`: N x J dense. Throws InputError when the surface is farther than 5 mm from symmetric, with distance
    /// and place, and where regions cannot be cut (cut_regions).
    SymmetricRemesher(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                      const Eigen::Ref<const RowMatrix>& weights, const Eigen::Ref<const Points>& joint_positions);
    ~SymmetricRemesher();
    SymmetricRemesher(SymmetricRemesher&&) noexcept;

    /// Edges of about `target_edge_length` on trunk and thick limbs, down to 0.4 of that where a limb is thin, so that
    /// nine or so go round it. On head, hands and toes the source's triangles are kept, thinned out to `keep_ratio` of
    /// their number, with a transition at the borders of the regions, which are smooth chains of edges on the cutting
    /// planes. Deterministic.
    RemeshedSkin remesh(double target_edge_length, double keep_ratio) const;

    /// Edge length that gives `num_prisms` prisms (two for each triangle of the body region) within 3 %, mostly 1 %.
    /// Throws InputError when no edge length between 3 and 80 mm does.
    double edge_length_for_prisms(int num_prisms) const;

private:
    struct State;
    std::unique_ptr<const State> state_;
};

/// Both in one call.
RemeshedSkin remesh_symmetric(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                              const Eigen::Ref<const RowMatrix>& weights,
                              const Eigen::Ref<const Points>& joint_positions, double target_edge_length,
                              double keep_ratio);
double edge_length_for_prisms(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                              const Eigen::Ref<const RowMatrix>& weights,
                              const Eigen::Ref<const Points>& joint_positions, int num_prisms);

}  // namespace ndg
