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

    /// A vertex of the wrap and a segment.
    struct Pair {
        int vertex, segment;
    };
    std::vector<Pair> pairs;  ///< those that probes and peaks look at, each once
    /// A vertex of the wrap that may meet a segment which has a part in it, among others.
    struct Probe {
        int pair;
        float share;  ///< weight of the segment
    };
    std::vector<Probe> probes;
    /// A vertex of a bone, and the wrap triangle over it.
    struct Peak {
        int anatomy_vertex, triangle;
        std::array<int, 3> pairs;  ///< of the triangle's vertices with the bone
    };
    std::vector<Peak> peaks;
    Triangles wrap_triangles;
    std::vector<std::vector<int>> triangles_of;  ///< of each vertex
    std::vector<char> at_rim;                    ///< of each vertex: 1 where the wrap is open
};

/// Of one body: distances to its bones, and how near it has them at rest.
class BoneClearance {
public:
    /// Keeps a reference to `probes`. `bone_wrap`: N_w x 3 at rest, `anatomy_rest`: N_a x 3.
    BoneClearance(const WrapProbes& probes, const BoneList& list, const Template& body_template,
                  const Eigen::Ref<const Points>& anatomy_rest, const Eigen::Ref<const Points>& bone_wrap);

    /// Moves wrap vertices outwards, along the wrap's normals, from bones that came nearer than `margin`, or than at
    /// rest where that was less, and over vertices of bones that came through. Neighbours go along a part of the way.
    /// The rest wrap with bones at rest stays as it is.
    void push_out(const Eigen::Ref<const Points>& rest_wrap, const std::vector<Eigen::Isometry3d>& segments,
                  Points& bone_wrap) const;

private:
    const WrapProbes* probes_;
    std::vector<ScalarGrid> distances_;  ///< of each segment
    std::vector<float> least_;           ///< of each probe, the distance that is kept
    std::vector<float> spare_;           ///< of each probe, by how much it is farther at rest; far away a lower bound
    Points peaks_;                       ///< at rest
    std::vector<int> peak_triangles_;    ///< the nearest at rest
    std::vector<double> allowed_;        ///< height of each peak over the wrap
    std::vector<float> peak_spare_;      ///< by how much it is lower at rest
};

}  // namespace ndg
