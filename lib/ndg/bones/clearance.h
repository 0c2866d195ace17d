// SPDX-License-Identifier: Apache-2.0
// Keeps bones inside the bone wrap.
#pragma once

#include "ndg/bones/bone_wrap.h"
#include "ndg/bones/wrap_foot.h"

#include <array>
#include <vector>

namespace ndg {

/// Where bones that move against each other may come through the wrap. Of a template.
struct WrapPeaks {
    /// `weights`: those of the wrap.
    WrapPeaks(const BoneList& list, const Template& body_template, const BoneWeights& weights);

    /// A vertex of a bone, and the wrap triangle over it at rest.
    struct Peak {
        int anatomy_vertex, segment, triangle;
    };
    std::vector<Peak> peaks;          ///< by segments
    std::vector<int> segment_begins;  ///< S + 1: where the peaks of each segment begin
    SurfaceNeighbours surface;        ///< the wrap
    SurfaceSpread spread;
};

/// Of one body: how near the wrap its bones are at rest.
class BoneClearance {
public:
    /// Keeps a reference to `peaks`. `bone_wrap`: N_w x 3 at rest, `anatomy_rest`: N_a x 3.
    BoneClearance(const WrapPeaks& peaks, const Eigen::Ref<const Points>& anatomy_rest,
                  const Eigen::Ref<const Points>& bone_wrap);

    /// Moves the wrap outwards, in smooth bumps, where bones come through it or come nearer than they are kept. The
    /// rest wrap with bones at rest stays as it is. The same for any number of threads.
    void push_out(const std::vector<Eigen::Isometry3d>& segments, Points& bone_wrap) const;

private:
    struct Scratch;
    void look_over(const std::vector<Eigen::Isometry3d>& segments, Scratch& scratch) const;
    void watch(Scratch& scratch) const;
    bool pushes_of(Scratch& scratch) const;

    const WrapPeaks* peaks_;
    FollowedPoints rest_;                             ///< the peaks at rest, with their allowed heights
    std::vector<float> spare_;                        ///< by how much each is lower at rest
    std::vector<int> segment_begins_;                 ///< where those of each segment begin, a multiple of the lanes
    std::array<std::vector<int>, 3> corners_;         ///< of their triangles
    std::array<std::vector<float>, 9> rest_corners_;  ///< x, y, z of each of them at rest
};

}  // namespace ndg
