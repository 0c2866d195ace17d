// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/frame_protrusion.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/geometry/winding_tree.h"

#include <vector>

namespace ndg {

FrameProtrusion frame_protrusion(const FrameSkin& skin, const Eigen::Ref<const Points>& inside_vertices,
                                 const Eigen::Ref<const Triangles>& inside)
{
    FrameProtrusion frame;
    int last = -1;
    for (const auto& [triangle, crossed] : crossing_triangles(inside_vertices, inside, skin.vertices, skin.compared)) {
        frame.intersecting_triangles += triangle != last;
        last = triangle;
    }

    std::vector<char> counts(inside_vertices.rows(), 0);
    for (Eigen::Index i = 0; i < inside.size(); ++i) counts[inside.data()[i]] = 1;
    const WindingTree winding(skin.vertices, skin.closed);
    std::vector<char> outside(counts.size(), 0);
    const int num_vertices = int(counts.size());
#pragma omp parallel for schedule(dynamic, 256)
    for (int v = 0; v < num_vertices; ++v)
        if (counts[v]) outside[v] = winding.winding_number(inside_vertices.row(v).transpose()) < 0.5;

    const TriangleTree surface(skin.vertices, skin.closed);
    for (int v = 0; v < num_vertices; ++v) {
        if (!outside[v]) continue;
        const double depth_mm = 1e3 * surface.closest(inside_vertices.row(v).transpose()).distance;
        ++frame.protruding_vertices;
        frame.depth_sum_mm += depth_mm;
        if (frame.deepest_vertex < 0 || depth_mm > frame.max_depth_mm) frame.deepest_vertex = v;
        frame.max_depth_mm = std::max(frame.max_depth_mm, depth_mm);
    }
    return frame;
}

void ProtrusionSum::add(const FrameProtrusion& frame, const std::string& deepest)
{
    ++row_.frames;
    intersecting_ += frame.intersecting_triangles > 0;
    protruding_ += frame.protruding_vertices > 0;
    vertices_ += frame.protruding_vertices;
    depth_sum_mm_ += frame.depth_sum_mm;
    if (frame.protruding_vertices > 0 && (row_.deepest.empty() || frame.max_depth_mm > row_.max_protrusion_mm)) {
        row_.deepest = deepest;
        row_.max_protrusion_mm = frame.max_depth_mm;
    }
}

ProtrusionRow ProtrusionSum::row() const
{
    require(row_.frames > 0, "There is no frame of {} in which protrusion could be measured", row_.method);
    ProtrusionRow row = row_;
    row.intersecting_frames = 100.0 * intersecting_ / row.frames;
    row.protruding_frames = 100.0 * protruding_ / row.frames;
    row.protrusion_mm = vertices_ > 0 ? depth_sum_mm_ / double(vertices_) : 0.0;
    return row;
}

}  // namespace ndg
