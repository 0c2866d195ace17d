// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body_source/template_source.h"
#include "ndg/core/options.h"

#include <string>
#include <vector>

namespace ndg {

/// Least depth under the skin, m. Where the body is thinner than five times that (fingers, toes), proportionally less.
struct CoverOptions {
    double bone = 0.004;
    double muscle = 0.0025;
};
void describe(OptionList& list, CoverOptions& options);

struct CoverReport {
    double min_bone_before = 0, min_muscle_before = 0;  ///< smallest depth under the skin, m; negative outside
    double min_bone = 0, min_muscle = 0;                ///< the same afterwards, where the body is thick enough
    std::string worst_bone, worst_muscle;               ///< parts with the smallest depth afterwards
    double min_thin = 0;                                ///< smallest depth afterwards where it is not
    int thin_vertices = 0;                              ///< asked for less than the full cover
    int moved_vertices = 0;                             ///< by more than 0.1 mm
    double max_displacement = 0;                        ///< m
};

/// Moves anatomy that lies too near to the skin, or outside of it, inwards: a displacement smooth in space, first on
/// coarse grids and then on finer ones (DisplacementField), the same for parts that lie together, so that neighbours do
/// not come to intersect more than before; what is left then is compressed along the skin's inward direction by a
/// monotone map of depth, which keeps the order of what lies on top of each other. For bones of the skull (`joint` head
/// or jaw) the inside of the mouth is no outside. `skin` is closed and outward. The anatomy keeps its triangles.
/// Deterministic.
/// Throws Error naming the part when a part cannot be brought inside.
CoverReport cover_with_skin(const Eigen::Ref<const Points>& skin_vertices,
                            const Eigen::Ref<const Triangles>& skin_triangles, std::vector<AnatomyMesh>& anatomy,
                            const CoverOptions& options);

}  // namespace ndg
