// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/soft_tissue_layer.h"

#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_crossings.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

namespace ndg {

namespace {

/// Prisms below this scaled Jacobian count as folded: what TetGen fills would be needles.
constexpr double least_scaled_jacobian = 0.02;
/// Cosine of the most that a direction may lean away from the inward normals around it, 70 degrees.
constexpr double least_normal_share = 0.34;
constexpr int middle_steps = 100;
/// How much is left of the thickness above the least, in each step of lowering.
constexpr double lowering = 0.85;
constexpr int max_lowerings = 80;
constexpr double least_flesh_weight = 0.1;

double smooth_step(double t)
{
    const double s = std::clamp(t, 0.0, 1.0);
    return s * s * (3 - 2 * s);
}

/// The direction that leans least from the farthest of unit vectors: the middle of the smallest ball about them
/// (Badoiu and Clarkson 2003), which for points of a sphere lies below the middle of the smallest cap.
Eigen::Vector3d middle_direction(const std::vector<Eigen::Vector3d>& directions)
{
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& direction : directions) middle += direction / double(directions.size());
    for (int step = 1; step <= middle_steps; ++step) {
        const auto farthest = std::max_element(directions.begin(), directions.end(), [&](const auto& x, const auto& y) {
            return (x - middle).squaredNorm() < (y - middle).squaredNorm();
        });
        middle += (*farthest - middle) / (step + 1);
    }
    return middle.norm() > 1e-6 ? Eigen::Vector3d(middle.normalized()) : directions.front();
}

double least_cosine(const Eigen::Vector3d& direction, const std::vector<Eigen::Vector3d>& others)
{
    double least = 1;
    for (const Eigen::Vector3d& other : others) least = std::min(least, direction.dot(other));
    return least;
}

/// `direction` turned as little towards the middle of the inward normals around a vertex as makes it lean no more than
/// `least_normal_share` says from any of them, or, in creases where that cannot be, three quarters of what can.
Eigen::Vector3d turned_inward(const Eigen::Vector3d& direction, const std::vector<Eigen::Vector3d>& inward_normals)
{
    const Eigen::Vector3d middle = middle_direction(inward_normals);
    const double wanted = std::min(least_normal_share, 0.75 * least_cosine(middle, inward_normals));
    if (least_cosine(direction, inward_normals) >= wanted) return direction;
    double low = 0, high = 1;
    Eigen::Vector3d best = middle;
    for (int step = 0; step < 30; ++step) {
        const double share = 0.5 * (low + high);
        const Eigen::Vector3d blend = (1 - share) * direction + share * middle;
        const bool enough = blend.norm() > 1e-6 && least_cosine(blend.normalized(), inward_normals) >= wanted;
        if (enough) best = blend.normalized();
        (enough ? high : low) = share;
    }
    return best;
}

/// Values at most `slope` times the edge's length above those of neighbours.
void limit_slope(const std::vector<std::vector<int>>& neighbours, const Eigen::Ref<const Points>& vertices,
                 double slope, std::vector<double>& values)
{
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (std::size_t v = 0; v < values.size(); ++v) queue.emplace(values[v], int(v));
    while (!queue.empty()) {
        const auto [value, v] = queue.top();
        queue.pop();
        if (value > values[v]) continue;
        for (const int other : neighbours[v]) {
            const double limit = value + slope * (vertices.row(v) - vertices.row(other)).norm();
            if (limit >= values[other]) continue;
            values[other] = limit;
            queue.emplace(limit, other);
        }
    }
}

/// Pairs that cross and have no common vertex: where neighbours fold, their prisms do; flat ones are found to cross by
/// rounding.
std::vector<std::pair<int, int>> crossings_apart(const Eigen::Ref<const Points>& vertices,
                                                 const Eigen::Ref<const Triangles>& triangles)
{
    std::vector<std::pair<int, int>> apart;
    for (const auto& [s, t] : crossing_triangles(vertices, triangles)) {
        bool neighbours = false;
        for (int c = 0; c < 3; ++c) neighbours = neighbours || (triangles.row(s).array() == triangles(t, c)).any();
        if (!neighbours) apart.emplace_back(s, t);
    }
    return apart;
}

}  // namespace

void describe(OptionList& list, LayerOptions& options)
{
    list.add("min-thickness", options.min_thickness, "least thickness of the soft tissue, m", 1e-4, 0.1);
    list.add("bone-radius", options.bone_radius, "how far the soft tissue ends before the bones' axes, m", 0, 0.2);
    list.add("rim-thickness", options.rim_thickness, "thickness where it ends, at head, hands and feet, m", 1e-4, 0.1);
    list.add("rim-fade", options.rim_fade, "distance over which the thickness grows from there, m", 0, 1);
    list.add("smoothing-length", options.smoothing_length,
             "distance on the skin over which projections to the bones are evened out, m; 0: not at all", 0, 10);
    list.add("max-slope", options.max_slope, "most that the greatest thickness changes over a distance on the skin",
             0.05, 10);
}

std::vector<int> folded_triangles(const SoftRegion& region, const Eigen::Ref<const Points>& outer,
                                  const Eigen::Ref<const Points>& inward, const std::vector<double>& thickness)
{
    const Points inner = inner_surface(outer, inward, thickness);
    const Eigen::Index count = region.triangles.rows();
    std::set<int> folded;
    for (Eigen::Index t = 0; t < count; ++t) {
        PrismVertices prism;
        for (int c = 0; c < 3; ++c) {
            prism.row(c) = outer.row(region.triangles(t, c));
            prism.row(3 + c) = inner.row(region.triangles(t, c));
        }
        if (!(prism_min_scaled_jacobian(prism) >= least_scaled_jacobian)) folded.insert(int(t));
    }
    const TriangleMesh surface = layer_surface(region, outer, inner);
    const auto mark = [&](int t) {
        if (t < 2 * count) {
            folded.insert(int(t % count));
            return;
        }
        // A triangle of the band along a rim: those of the region that have a vertex of it.
        for (Eigen::Index other = 0; other < count; ++other)
            for (int c = 0; c < 3; ++c)
                if ((surface.triangles.row(t).array() == region.triangles(other, c)).any()) folded.insert(int(other));
    };
    for (const auto& [s, t] : crossings_apart(surface.vertices, surface.triangles)) {
        mark(s);
        mark(t);
    }
    return {folded.begin(), folded.end()};
}

int unfold_thickness(const SoftRegion& region, const Eigen::Ref<const Points>& outer,
                     const Eigen::Ref<const Points>& inward, const std::vector<double>& least, double max_slope,
                     std::vector<double>& thickness)
{
    const std::vector<double> wanted = thickness;
    const std::vector<std::vector<int>> neighbours = vertex_neighbours(region.triangles, region.size());
    for (int step = 0;; ++step) {
        const std::vector<int> folded = folded_triangles(region, outer, inward, thickness);
        if (folded.empty()) break;
        std::set<int> vertices;
        for (const int t : folded)
            for (int c = 0; c < 3; ++c) vertices.insert(region.triangles(t, c));
        bool lowered = false;
        for (const int v : vertices) {
            if (thickness[v] <= least[v]) continue;
            lowered = true;
            const double rest = lowering * (thickness[v] - least[v]);
            thickness[v] = least[v] + (rest < 1e-5 ? 0.0 : rest);
        }
        const int first = *vertices.begin();
        require_input(lowered && step < max_lowerings,
                      "the soft tissue folds over in {} triangles, even where it is as thin as it may be, as at skin "
                      "vertex {} ({:.3f}, {:.3f}, {:.3f})",
                      folded.size(), region.skin_vertices[first], outer(first, 0), outer(first, 1), outer(first, 2));
        limit_slope(neighbours, outer, max_slope, thickness);
        for (std::size_t v = 0; v < thickness.size(); ++v) thickness[v] = std::max(thickness[v], least[v]);
    }
    int count = 0;
    for (std::size_t v = 0; v < thickness.size(); ++v) count += thickness[v] < wanted[v];
    return count;
}

std::vector<bool> flesh_joints(const SoftRegion& region, const JointWeights& weights)
{
    std::vector<bool> moves(weights.cols(), false);
    for (const int v : region.skin_vertices)
        for (JointWeights::InnerIterator entry(weights, v); entry; ++entry)
            if (entry.value() >= least_flesh_weight) moves[entry.col()] = true;
    return moves;
}

SoftTissueLayer soft_tissue_layer(const Eigen::Ref<const Points>& outer, const SoftRegion& region,
                                  const SkeletonTree& tree, const LayerOptions& options)
{
    check_options(options);
    require_input(options.rim_thickness <= options.min_thickness,
                  "the thickness at the rims, {} m, is more than the least elsewhere, {} m", options.rim_thickness,
                  options.min_thickness);
    const auto crossings = crossings_apart(outer, region.triangles);
    if (!crossings.empty()) {
        const int v = region.triangles(crossings.front().first, 0);
        throw InputError(
            fmt::format("the skin crosses itself in {} places, as at skin vertex {} ({:.3f}, {:.3f}, {:.3f})",
                        crossings.size(), region.skin_vertices[v], outer(v, 0), outer(v, 1), outer(v, 2)));
    }
    const Points normals = triangle_normals(outer, region.triangles);
    std::vector<std::vector<Eigen::Vector3d>> inward_normals(region.size());
    for (Eigen::Index t = 0; t < region.triangles.rows(); ++t)
        for (int c = 0; c < 3; ++c) inward_normals[region.triangles(t, c)].emplace_back(-normals.row(t).transpose());

    SoftTissueLayer layer;
    layer.projections = project_to_skeleton(tree, outer, region.triangles, {options.smoothing_length});
    layer.inward.resize(region.size(), 3);
    for (int v = 0; v < region.size(); ++v) {
        const Eigen::Vector3d skin_point = outer.row(v);
        const Eigen::Vector3d way = tree.position(layer.projections[v]) - skin_point;
        const double depth = way.norm();
        const Eigen::Vector3d direction = depth > 1e-9 ? Eigen::Vector3d(way / depth) : inward_normals[v].front();
        const Eigen::Vector3d inward = turned_inward(direction, inward_normals[v]);
        layer.num_turned += inward != direction;
        layer.inward.row(v) = inward.transpose();

        const double share = options.rim_fade > 0 ? smooth_step(region.rim_distances[v] / options.rim_fade) : 1.0;
        const double at_most = std::max(options.min_thickness, depth - options.bone_radius);
        layer.num_thin += depth - options.bone_radius < options.min_thickness;
        layer.min_thickness.push_back(options.rim_thickness + share * (options.min_thickness - options.rim_thickness));
        layer.max_thickness.push_back(options.rim_thickness + share * (at_most - options.rim_thickness));
    }
    const std::vector<double> rim(region.size(), options.rim_thickness);
    unfold_thickness(region, outer, layer.inward, rim, options.max_slope, layer.min_thickness);
    limit_slope(vertex_neighbours(region.triangles, region.size()), outer, options.max_slope, layer.max_thickness);
    for (int v = 0; v < region.size(); ++v)
        layer.max_thickness[v] = std::max(layer.max_thickness[v], layer.min_thickness[v]);
    layer.num_lowered =
        unfold_thickness(region, outer, layer.inward, layer.min_thickness, options.max_slope, layer.max_thickness);
    return layer;
}

}  // namespace ndg
