// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/frame_protrusion.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/geometry/winding_tree.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace ndg {

namespace {

/// The connected piece of each vertex, named by one of its vertices; -1 for vertices of no triangle.
std::vector<int> pieces_of(const Eigen::Ref<const Triangles>& triangles, int num_vertices)
{
    std::vector<int> parents(num_vertices, -1);
    const auto root = [&](int v) {
        while (parents[v] != v) v = parents[v] = parents[parents[v]];
        return v;
    };
    for (Eigen::Index i = 0; i < triangles.size(); ++i) parents[triangles.data()[i]] = triangles.data()[i];
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        for (int k = 1; k < 3; ++k) parents[root(triangles(t, k))] = root(triangles(t, 0));
    for (int v = 0; v < num_vertices; ++v)
        if (parents[v] >= 0) parents[v] = root(v);
    return parents;
}

}  // namespace

FrameProtrusion frame_protrusion(const FrameSkin& skin, const Eigen::Ref<const Points>& inside_vertices,
                                 const Eigen::Ref<const Triangles>& inside)
{
    require(skin.compared.size() == std::size_t(skin.triangles.rows()), "{} triangles of a skin have {} marks",
            skin.triangles.rows(), skin.compared.size());
    FrameProtrusion frame;
    const std::vector<int> pieces = pieces_of(inside, int(inside_vertices.rows()));
    std::vector<char> crossing(inside_vertices.rows(), 0);  // of each piece
    // By a nanometre in no particular direction: an edge that meets an edge exactly, as in bodies that are their own
    // mirror image, would cross neither of its triangles.
    const Points shifted = inside_vertices.rowwise() + 1e-9 * Eigen::RowVector3d(0.31, 0.73, 0.61);
    for (const auto& [triangle, crossed] : crossing_triangles(shifted, inside, skin.vertices, skin.triangles)) {
        crossing[pieces[inside(triangle, 0)]] = 1;
        const bool known = !frame.intersecting.empty() && frame.intersecting.back() == triangle;
        if (skin.compared[crossed] && !known) frame.intersecting.push_back(triangle);
    }

    // A piece that does not cross the skin lies inside or outside of it as a whole.
    const WindingTree winding(skin.vertices, skin.triangles);
    std::vector<char> outside(inside_vertices.rows(), 0);
    const int num_vertices = int(outside.size());
#pragma omp parallel for schedule(dynamic, 64)
    for (int v = 0; v < num_vertices; ++v)
        if (pieces[v] == v || (pieces[v] >= 0 && crossing[pieces[v]]))
            outside[v] = winding.winding_number(inside_vertices.row(v).transpose()) < 0.5;
    for (int v = 0; v < num_vertices; ++v)
        if (pieces[v] >= 0 && !crossing[pieces[v]]) outside[v] = outside[pieces[v]];

    std::optional<TriangleTree> surface;  // most frames need none
    for (int v = 0; v < num_vertices; ++v) {
        if (!outside[v]) continue;
        if (!surface) surface.emplace(skin.vertices, skin.triangles);
        const auto nearest = surface->closest(inside_vertices.row(v).transpose());
        if (!skin.compared[nearest.triangle_idx]) continue;
        const double depth_mm = 1e3 * nearest.distance;
        ++frame.protruding_vertices;
        frame.depth_sum_mm += depth_mm;
        if (frame.deepest_vertex < 0 || depth_mm > frame.max_depth_mm) frame.deepest_vertex = v;
        frame.max_depth_mm = std::max(frame.max_depth_mm, depth_mm);
    }
    return frame;
}

void ProtrusionSum::add(const FrameProtrusion& frame, const std::string& sample, const std::string& deepest,
                        const std::set<std::string>& parts)
{
    ++row_.frames;
    intersecting_ += !frame.intersecting.empty();
    for (const std::string& part : parts) ++row_.intersecting_parts[part];
    protruding_ += frame.protruding_vertices > 0;
    vertices_ += frame.protruding_vertices;
    depth_sum_mm_ += frame.depth_sum_mm;
    if (frame.protruding_vertices == 0) return;
    ++row_.protruding_parts[deepest];
    if (row_.deepest.empty() || frame.max_depth_mm > row_.max_protrusion_mm) {
        row_.deepest = deepest + " of " + sample;
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
