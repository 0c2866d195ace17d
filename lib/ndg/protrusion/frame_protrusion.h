// SPDX-License-Identifier: Apache-2.0
// Where bones and muscles pass through a skin and stick out of it (NDG 5.3, Table 3).
#pragma once

#include "ndg/core/types.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace ndg {

/// The skin of one frame. A protruding point is one whose winding number in the whole closed skin is below a half and
/// whose nearest triangle is compared: what comes into the mouth of a head's skin, say, does not count.
struct FrameSkin {
    Points vertices;             ///< N_s x 3, m
    Triangles triangles;         ///< closed, outward
    std::vector<char> compared;  ///< of each triangle, whether what passes it counts: neither head nor hands nor toes
};

/// How what lies inside meets the skin in one frame.
struct FrameProtrusion {
    std::vector<int> intersecting;  ///< of `inside`, triangles that cross the compared skin, ascending
    int protruding_vertices = 0;    ///< of `inside`, outside of the skin
    double depth_sum_mm = 0;        ///< their distances to the skin
    double max_depth_mm = 0;
    int deepest_vertex = -1;  ///< of inside_vertices; -1: none
};

/// `inside`: those triangles of bones and muscles that count, into `inside_vertices`; vertices of no such triangle do
/// not count. Throws Error for a skin without triangles.
FrameProtrusion frame_protrusion(const FrameSkin& skin, const Eigen::Ref<const Points>& inside_vertices,
                                 const Eigen::Ref<const Triangles>& inside);

/// One row of Table 3. Shares are in percent of the frames.
struct ProtrusionRow {
    std::string method;
    int frames = 0;
    double intersecting_frames = 0;  ///< with a crossing
    double protruding_frames = 0;    ///< with a vertex outside
    double protrusion_mm = 0;        ///< mean distance to the skin of all vertices outside, 0 for none
    double max_protrusion_mm = 0;
    std::string deepest;                            ///< what sticks out deepest, in words; empty for nothing
    std::map<std::string, int> intersecting_parts;  ///< bone, muscle or tissue -> frames in which it crosses the skin
    std::map<std::string, int> protruding_parts;    ///< the same -> frames in which it sticks out deepest
};

/// Adds frames up to a row.
class ProtrusionSum {
public:
    explicit ProtrusionSum(std::string method) { row_.method = std::move(method); }
    /// `sample`: the frame in words; `deepest`: bone, muscle or tissue of its deepest vertex; `parts`: those of its
    /// crossing triangles.
    void add(const FrameProtrusion& frame, const std::string& sample, const std::string& deepest,
             const std::set<std::string>& parts);
    /// Throws Error where no frame was added.
    ProtrusionRow row() const;

private:
    ProtrusionRow row_;
    int intersecting_ = 0, protruding_ = 0;
    long vertices_ = 0;
    double depth_sum_mm_ = 0;
};

}  // namespace ndg
