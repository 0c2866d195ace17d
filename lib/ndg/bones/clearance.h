// SPDX-License-Identifier: Apache-2.0
// Keeps bones inside the bone wrap.
#pragma once

#include "ndg/bones/bone_wrap.h"
#include "ndg/geometry/distance_grid.h"

#include <array>
#include <vector>

namespace ndg {

/// Where bones that move against each other may come through the wrap. Of a template.
struct WrapProbes {
    /// `bone_weights`: those of the wrap.
    WrapProbes(const BoneList& list, const Template& body_template, const BoneWeights& bone_weights);

    /// A place on the wrap, the mean of three vertices (one of them repeated, or those of a triangle), in which several
    /// segments have a part.
    struct Probe {
        std::array<int, 3> vertices;
        int begin, end;  ///< of the segments it may meet
    };
    std::vector<Probe> probes;
    std::vector<int> segments;
    std::vector<float> shares;  ///< mean weight of each of these
    /// A vertex of a bone, and the wrap triangles over it: the nearest and those beside it.
    struct Peak {
        int anatomy_vertex, segment;
        std::array<int, 4> triangles;
    };
    std::vector<Peak> peaks;
    Triangles wrap_triangles;
    std::vector<std::vector<int>> triangles_of;  ///< of each vertex
};

/// Of one body: distances to its bones, and how near it has them at rest.
class BoneClearance {
public:
    /// Keeps a reference to `probes`. `bone_wrap`: N_w x 3 at rest, `anatomy_rest`: N_a x 3.
    BoneClearance(const WrapProbes& probes, const BoneList& list, const Template& body_template,
                  const Eigen::Ref<const Points>& anatomy_rest, const Eigen::Ref<const Points>& bone_wrap);

    /// Moves wrap vertices outwards, along the wrap's normals, from bones that came nearer than `margin`, or than at
    /// rest where that was less. The rest wrap with bones at rest stays as it is.
    void push_out(const Eigen::Ref<const Points>& rest_wrap, const std::vector<Eigen::Isometry3d>& segments,
                  Points& bone_wrap) const;

private:
    const WrapProbes* probes_;
    std::vector<ScalarGrid> distances_;               ///< of each segment
    std::vector<float> least_;                        ///< of each probe and segment, the distance that is kept
    std::vector<float> rest_distances_;               ///< of each probe and segment; far away a lower bound
    Points rest_places_;                              ///< of the probes
    Points peaks_;                                    ///< at rest
    std::vector<float> peak_depths_;                  ///< under what is allowed over the nearest triangle
    std::vector<std::array<float, 4>> peak_heights_;  ///< over its triangles, what is allowed
};

}  // namespace ndg
