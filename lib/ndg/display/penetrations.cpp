// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/penetrations.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/geometry/winding_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

const std::string skin_name = "skin", itself_name = "itself";

/// A vertex lies on its own surface; inside another part of it, its winding number is larger by one.
constexpr double inside_another_part = 1.05;

struct Surface {
    Points vertices;
    Triangles triangles;
};

/// Adds what a frame has.
void add(PenetrationCount& count, int vertices, double depth, double seconds)
{
    if (vertices == 0) return;
    ++count.frames;
    count.most_vertices = std::max(count.most_vertices, vertices);
    if (depth > count.deepest_metre) {
        count.deepest_metre = depth;
        count.deepest_seconds = seconds;
    }
}

struct Tally {
    std::array<int, 2> vertices{};  ///< of soft and of held skin
    std::array<double, 2> depths{};

    void add(bool held, double depth)
    {
        ++vertices[held];
        depths[held] = std::max(depths[held], depth);
    }
};

/// Calls use(vertex, closest point of the outer surface) for vertices of the first inside the second.
template <typename Use>
void for_vertices_inside(const Surface& inner, const Surface& outer, const Use& use)
{
    const Eigen::RowVector3d low = outer.vertices.colwise().minCoeff(), high = outer.vertices.colwise().maxCoeff();
    std::vector<Eigen::Index> candidates;
    for (Eigen::Index v = 0; v < inner.vertices.rows(); ++v) {
        const auto point = inner.vertices.row(v).array();
        if ((point >= low.array()).all() && (point <= high.array()).all()) candidates.push_back(v);
    }
    if (candidates.empty()) return;
    const WindingTree winding(outer.vertices, outer.triangles);
    const TriangleTree tree(outer.vertices, outer.triangles);
    for (const Eigen::Index v : candidates) {
        const Eigen::Vector3d point = inner.vertices.row(v);
        if (winding.winding_number(point) >= 0.5) use(static_cast<int>(v), tree.closest(point));
    }
}

/// Distance of a vertex to the parts of its surface that are far from it at rest.
double depth_in_itself(const DynamicsDisplay& display, const Points& skin, int vertex, double apart)
{
    const Triangles& triangles = display.triangles();
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        bool far = true;
        for (int k = 0; k < 3; ++k) {
            far &= (display.rest().row(triangles(t, k)) - display.rest().row(vertex)).norm() > apart;
        }
        if (!far) continue;
        const ClosestPoint closest =
            closest_point_on_triangle(skin.row(vertex).transpose(), skin.row(triangles(t, 0)).transpose(),
                                      skin.row(triangles(t, 1)).transpose(), skin.row(triangles(t, 2)).transpose());
        least = std::min(least, closest.distance);
    }
    return std::isfinite(least) ? least : 0;
}

Tally inside_itself(const DynamicsDisplay& display, const Points& skin, double apart)
{
    Tally tally;
    // Nothing gets inside without crossing, which is found sooner.
    if (crossing_triangles(skin, display.triangles()).empty()) return tally;
    const WindingTree winding(skin, display.triangles());
    for (int v = 0; v < skin.rows(); ++v) {
        if (winding.winding_number(skin.row(v).transpose()) < inside_another_part) continue;
        tally.add(display.soft()[static_cast<std::size_t>(v)] == 0, depth_in_itself(display, skin, v, apart));
    }
    return tally;
}

}  // namespace

std::vector<PenetrationCount> count_penetrations(const DynamicsDisplay& display, int sequence, double apart)
{
    std::vector<PenetrationCount> counts;
    // Soft, then held.
    const auto begin_pair = [&](const std::string& inner, const std::string& outer) {
        for (const bool held : {false, true}) counts.push_back({inner, outer, held, 0, 0, 0, 0});
        return counts.size() - 2;
    };
    const DynamicsSet& set = display.set();
    std::vector<std::size_t> in_other(set.others.size()), in_skin(set.others.size());
    for (std::size_t i = 0; i < set.others.size(); ++i) {
        if (!set.others[i].garment) in_other[i] = begin_pair(skin_name, set.others[i].name);
        in_skin[i] = begin_pair(set.others[i].name, skin_name);
    }
    const bool closed = closed_surface_defect(display.rest(), display.triangles()).empty();
    const std::size_t own = closed ? begin_pair(skin_name, itself_name) : 0;
    const bool compare = closed && display.has_skinned();
    const std::size_t skinned = compare ? begin_pair(skin_name, itself_name + " by skinning alone") : 0;

    const auto [begin, end] = set.frames_of(sequence);
    for (int frame = begin; frame < end; ++frame) {
        const double seconds = set.times[static_cast<std::size_t>(frame)];
        const Points positions = display.reader().frame(frame);
        const Surface skin{display.skin(frame, positions), display.triangles()};
        const auto record = [&](std::size_t first, const Tally& tally) {
            for (const std::size_t held : {0u, 1u})
                add(counts[first + held], tally.vertices[held], tally.depths[held], seconds);
        };
        for (std::size_t i = 0; i < set.others.size(); ++i) {
            const Triangles& triangles = set.others[i].triangles;
            const int first = triangles.minCoeff();
            const Surface other{positions.middleRows(first, triangles.maxCoeff() + 1 - first),
                                triangles.array() - first};
            if (!set.others[i].garment) {
                Tally tally;
                for_vertices_inside(skin, other, [&](int vertex, const ClosestPoint& closest) {
                    tally.add(display.soft()[static_cast<std::size_t>(vertex)] == 0, closest.distance);
                });
                record(in_other[i], tally);
            }
            Tally tally;
            for_vertices_inside(other, skin, [&](int, const ClosestPoint& closest) {
                bool held = true;
                for (int k = 0; k < 3; ++k) {
                    held &= display.soft()[static_cast<std::size_t>(skin.triangles(closest.triangle_idx, k))] == 0;
                }
                tally.add(held, closest.distance);
            });
            record(in_skin[i], tally);
        }
        if (closed) record(own, inside_itself(display, skin.vertices, apart));
        if (compare) record(skinned, inside_itself(display, display.skinned(frame), apart));
    }
    return counts;
}

std::string penetration_lines(const std::vector<PenetrationCount>& counts)
{
    std::string text;
    for (const PenetrationCount& count : counts) {
        const std::string what = fmt::format("{} inside {}, {}", count.inner, count.outer,
                                             count.held ? "where skin is held" : "where skin gives way");
        text +=
            count.frames == 0
                ? fmt::format("  {}: no vertex in any frame\n", what)
                : fmt::format("  {}: in {} frames, at most {} vertices, the deepest by {:.2f} mm at {:.2f} s\n", what,
                              count.frames, count.most_vertices, 1e3 * count.deepest_metre, count.deepest_seconds);
    }
    return text;
}

void require_apart(const std::vector<PenetrationCount>& counts)
{
    for (const PenetrationCount& count : counts) {
        const bool with_itself = count.outer.compare(0, itself_name.size(), itself_name) == 0;
        if (count.frames == 0 || count.held || with_itself) continue;
        throw QualityError(fmt::format("{} is inside {} by {:.2f} mm at {:.2f} s", count.inner, count.outer,
                                       1e3 * count.deepest_metre, count.deepest_seconds));
    }
}

}  // namespace ndg
