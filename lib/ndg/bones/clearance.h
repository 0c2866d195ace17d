// SPDX-License-Identifier: Apache-2.0
// Keeps bones inside the bone wrap.
#pragma once

#include "ndg/bones/bone_wrap.h"
#include "ndg/bones/surface_spread.h"

#include <array>
#include <vector>

namespace ndg {

/// Where bones that move against each other may come through the wrap. Of a template.
struct WrapPeaks {
    /// `weights`: those of the wrap.
    WrapPeaks(const BoneList& list, const Template& body_template, const BoneWeights& weights);

    /// A vertex of the wrap and a segment near it.
    struct Pair {
        int vertex, segment;
    };
    /// A vertex of a bone, and the wrap triangle over it at rest.
    struct Peak {
        int anatomy_vertex, segment, triangle;
        std::array<int, 3> pairs;  ///< of the triangle's vertices with the segment
    };
    std::vector<Pair> pairs;  ///< those of the peaks, each once
    std::vector<Peak> peaks;
    Triangles triangles;                         ///< of the wrap
    std::vector<std::array<int, 3>> beside;      ///< of each triangle, across the edge opposite to a corner; -1: none
    std::vector<std::vector<int>> triangles_of;  ///< of each vertex
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
    std::vector<int> may_come_through(const std::vector<Eigen::Isometry3d>& segments, const Points& bone_wrap) const;

    const WrapPeaks* peaks_;
    Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> rest_wrap_;
    Points points_;                ///< of the peaks at rest
    std::vector<int> triangles_;   ///< the nearest at rest
    std::vector<double> allowed_;  ///< height of each peak over the wrap
    std::vector<float> spare_;     ///< by how much it is lower at rest
};

}  // namespace ndg
