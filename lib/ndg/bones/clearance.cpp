// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/clearance.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace ndg {

namespace {

constexpr double widest = 0.060;  ///< m: first the wrap moves over this width about what came through, then over less

/// Where on the wrap a point lies.
struct Foot {
    int triangle = -1;
    double height = 0.0;                                       ///< of the point, negative inside
    Eigen::RowVector3d outwards = Eigen::RowVector3d::Zero();  ///< of length 1, along the line to the point
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
};

Eigen::RowVector3d area_normal(const Points& wrap, const Eigen::Ref<const Eigen::RowVector3i>& triangle)
{
    const Eigen::RowVector3d a = wrap.row(triangle[0]);
    return (wrap.row(triangle[1]) - a).cross(wrap.row(triangle[2]) - a);
}

/// The place nearest to a point as found by going down over the wrap from a triangle.
Foot nearest_foot(const WrapPeaks& peaks, const Points& wrap, const Eigen::Vector3d& point, int start)
{
    constexpr int most_steps = 12;
    const auto closest_on = [&](int t) {
        const auto triangle = peaks.triangles.row(t);
        ClosestPoint closest =
            closest_point_on_triangle(point, wrap.row(triangle[0]).transpose(), wrap.row(triangle[1]).transpose(),
                                      wrap.row(triangle[2]).transpose());
        closest.triangle_idx = t;
        return closest;
    };
    ClosestPoint best = closest_on(start);
    for (int step = 0, centre = -1; step < most_steps && centre != best.triangle_idx; ++step) {
        centre = best.triangle_idx;
        for (int c = 0; c < 3; ++c)
            for (const int t : peaks.triangles_of[peaks.triangles(centre, c)]) {
                if (t == centre) continue;
                const ClosestPoint other = closest_on(t);
                if (other.distance < best.distance) best = other;
            }
    }
    constexpr double on_edge = 1e-6;
    const auto corners = peaks.triangles.row(best.triangle_idx);
    Eigen::RowVector3d normal = area_normal(wrap, corners);
    if (best.barycentric.minCoeff() < on_edge) {
        // On an edge or at a corner: the mean of what meets there.
        normal.setZero();
        for (int c = 0; c < 3; ++c) {
            if (best.barycentric[c] < on_edge) continue;
            for (const int t : peaks.triangles_of[corners[c]])
                normal += best.barycentric[c] * area_normal(wrap, peaks.triangles.row(t)).normalized();
        }
    }
    const Eigen::RowVector3d line = (point - best.point).transpose();
    const bool outside = line.dot(normal) > 0.0;
    constexpr double touching = 1e-6;  // m
    Foot foot{best.triangle_idx, outside ? best.distance : -best.distance, normal, best.barycentric};
    if (best.distance > touching) foot.outwards = outside ? line : Eigen::RowVector3d(-line);
    foot.outwards /= std::max(foot.outwards.norm(), 1e-20);
    return foot;
}

/// Goes over the wrap from triangle to triangle to one under or over the point: a bone that slides under the wrap is
/// followed, and another fold of the wrap that touches this one is not taken for it. Where the point lies over an edge
/// and may be higher than `allowed`, the nearest place is looked for.
Foot find_foot(const WrapPeaks& peaks, const Points& wrap, const Eigen::Vector3d& point, int start, double allowed)
{
    constexpr int most_steps = 16;
    int t = start, previous = -1;
    double previous_height = 0.0;
    for (int step = 0; step < most_steps; ++step) {
        const auto corners = peaks.triangles.row(t);
        const Eigen::Vector3d a = wrap.row(corners[0]).transpose(), u = wrap.row(corners[1]).transpose() - a,
                              v = wrap.row(corners[2]).transpose() - a, normal = u.cross(v), d = point - a;
        const double area = normal.squaredNorm();
        const Eigen::Vector3d across = normal.cross(d);
        // Barycentric coordinates times area: of u and v.
        const double second = across.dot(v), third = -across.dot(u), first = area - second - third;
        const double height = d.dot(normal) / std::sqrt(std::max(area, 1e-30));
        if (std::min({first, second, third}) >= 0.0)
            return {t, height, normal.transpose().normalized(), Eigen::Vector3d(first, second, third) / area};
        const int corner = first <= second && first <= third ? 0 : (second <= third ? 1 : 2);
        const int next = peaks.beside[t][std::size_t(corner)];
        if (next == previous && std::max(height, previous_height) <= allowed)
            return {t, std::max(height, previous_height), {}, {}};  // under an edge, at least as deep
        if (next < 0 || next == previous) break;
        previous = t;
        previous_height = height;
        t = next;
    }
    return nearest_foot(peaks, wrap, point, t);
}

}  // namespace

WrapPeaks::WrapPeaks(const BoneList& list, const Template& body_template, const BoneWeights& weights)
    : triangles(body_template.wrap_triangles),
      spread(body_template.rest.volume_vertices.topRows(body_template.num_wrap_vertices()), triangles, widest)
{
    constexpr double deepest = 0.020;  // m below the wrap at rest; what lies deeper does not come out
    constexpr double cell = 0.004, shallow = 0.008, cell_below = 0.008;  // m; cells of bones down to a depth, and below
    constexpr double own = 0.98;  // weight from which on a vertex moves with the bone
    const auto rides_on = [&](int v, int segment) {
        for (int k = weights.begins[v]; k < weights.begins[v + 1]; ++k)
            if (weights.segments[k] == segment) return weights.weights[k] >= own;
        return false;
    };
    const int num_wrap = body_template.num_wrap_vertices();
    triangles_of.resize(num_wrap);
    for (int t = 0; t < int(triangles.rows()); ++t)
        for (int k = 0; k < 3; ++k) triangles_of[triangles(t, k)].push_back(t);
    beside.assign(triangles.rows(), {-1, -1, -1});
    for (const MeshEdge& edge : mesh_edges(triangles, num_wrap)) {
        const auto opposite = [&](int t) {
            int corner = 0;
            while (triangles(t, corner) == edge.v0 || triangles(t, corner) == edge.v1) ++corner;
            return std::size_t(corner);
        };
        if (edge.right_triangle < 0) continue;
        beside[edge.left_triangle][opposite(edge.left_triangle)] = edge.right_triangle;
        beside[edge.right_triangle][opposite(edge.right_triangle)] = edge.left_triangle;
    }
    const TriangleTree tree(body_template.rest.volume_vertices.topRows(num_wrap), triangles);
    // Of the vertices in a cell of the bone the one nearest to the wrap stands for all.
    struct Candidate {
        Peak peak;
        double distance;
    };
    std::map<std::tuple<int, int, int, int>, Candidate> nearest;
    for (const BoneList::Bone& bone : list.bones)
        for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) {
            if (body_template.embedding.elements[v] < 0) continue;
            const Eigen::Vector3d point = body_template.anatomy_vertices.row(v).transpose();
            const ClosestPoint closest = tree.closest(point);
            if (closest.distance > deepest) continue;
            bool rides = true;
            for (int c = 0; c < 3; ++c)
                for (const int t : triangles_of[triangles(closest.triangle_idx, c)])
                    for (int k = 0; k < 3; ++k) rides = rides && rides_on(triangles(t, k), bone.segment);
            if (rides) continue;
            const bool is_shallow = closest.distance < shallow;
            const Eigen::Array3i c = (point / (is_shallow ? cell : cell_below)).array().floor().cast<int>();
            const Candidate candidate{{v, bone.segment, closest.triangle_idx, {}}, closest.distance};
            const auto [known, is_new] =
                nearest.try_emplace({2 * bone.segment + int(is_shallow), c[0], c[1], c[2]}, candidate);
            if (!is_new && candidate.distance < known->second.distance) known->second = candidate;
        }
    std::map<std::pair<int, int>, int> known_pairs;
    for (const auto& [place, candidate] : nearest) {
        peaks.push_back(candidate.peak);
        for (int k = 0; k < 3; ++k) {
            const Pair pair{triangles(candidate.peak.triangle, k), candidate.peak.segment};
            const auto [known, is_new] = known_pairs.try_emplace({pair.segment, pair.vertex}, int(pairs.size()));
            if (is_new) pairs.push_back(pair);
            peaks.back().pairs[std::size_t(k)] = known->second;
        }
    }
}

BoneClearance::BoneClearance(const WrapPeaks& peaks, const Eigen::Ref<const Points>& anatomy_rest,
                             const Eigen::Ref<const Points>& bone_wrap)
    : peaks_(&peaks), rest_wrap_(bone_wrap.cast<float>()), points_(Eigen::Index(peaks.peaks.size()), 3)
{
    constexpr double kept = 0.0004;  // m between bone and wrap
    const Points wrap = bone_wrap;
    for (std::size_t i = 0; i < peaks.peaks.size(); ++i) {
        const WrapPeaks::Peak& peak = peaks.peaks[i];
        points_.row(Eigen::Index(i)) = anatomy_rest.row(peak.anatomy_vertex);
        const Foot foot = find_foot(peaks, wrap, points_.row(Eigen::Index(i)).transpose(), peak.triangle, -kept);
        triangles_.push_back(foot.triangle);
        allowed_.push_back(std::max(-kept, foot.height));
        spare_.push_back(float(allowed_.back() - foot.height));
    }
}

/// The peaks under which the wrap moved against the bone by more than most of what is between them at rest.
std::vector<int> BoneClearance::may_come_through(const std::vector<Eigen::Isometry3d>& segments,
                                                 const Points& bone_wrap) const
{
    constexpr float most = 0.7F, least = 0.0002F;  // m
    std::vector<Eigen::Matrix<float, 3, 4>> motions;
    for (const Eigen::Isometry3d& motion : segments) motions.push_back(motion.matrix().topRows<3>().cast<float>());
    const std::vector<WrapPeaks::Pair>& pairs = peaks_->pairs;
    std::vector<float> ways(pairs.size());
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Eigen::Matrix<float, 3, 4>& motion = motions[pairs[i].segment];
        const Eigen::Vector3f rest = rest_wrap_.row(pairs[i].vertex).transpose(),
                              now = bone_wrap.row(pairs[i].vertex).transpose().cast<float>();
        ways[i] = (motion.leftCols<3>() * rest + motion.col(3) - now).norm();
    }
    std::vector<int> found;
    for (std::size_t i = 0; i < peaks_->peaks.size(); ++i) {
        const std::array<int, 3>& corners = peaks_->peaks[i].pairs;
        if (std::max({ways[corners[0]], ways[corners[1]], ways[corners[2]]}) > most * spare_[i] + least)
            found.push_back(int(i));
    }
    return found;
}

void BoneClearance::push_out(const std::vector<Eigen::Isometry3d>& segments, Points& bone_wrap) const
{
    constexpr int passes = 12;
    constexpr double narrowing = 0.85, narrowest = 0.013;  // m; of the width from pass to pass
    constexpr double ahead = 1.2;                          // the first look's pushes are spread and come out less
    constexpr double tolerance = 0.0003;                   // m
    constexpr double near = 0.003;       // m; what is farther from coming through at first does not come through later
    constexpr double least_part = 0.05;  // of a corner under a peak, from which on it is pushed
    struct Watched {
        int peak;
        Foot foot;
    };
    std::vector<Watched> watched;
    for (const int i : may_come_through(segments, bone_wrap)) watched.push_back({i, {triangles_[i], 0.0, {}, {}}});
    std::vector<char> moved(bone_wrap.rows(), 1);
    Points pushes = Points::Zero(bone_wrap.rows(), 3);
    double width = widest;
    for (int pass = 0; pass < passes; ++pass, width = std::max(narrowing * width, narrowest)) {
#pragma omp parallel for schedule(static)
        for (std::size_t k = 0; k < watched.size(); ++k) {
            auto& [i, foot] = watched[k];
            const auto corners = peaks_->triangles.row(foot.triangle);
            if (moved[corners[0]] == 0 && moved[corners[1]] == 0 && moved[corners[2]] == 0) continue;
            const Eigen::Vector3d point = segments[peaks_->peaks[i].segment] * points_.row(i).transpose();
            foot = find_foot(*peaks_, bone_wrap, point, foot.triangle, allowed_[i]);
        }
        std::vector<int> pushed;
        std::size_t num_near = 0;
        for (const Watched& one : watched) {
            const double missing = one.foot.height - allowed_[one.peak];
            if (missing <= -near) continue;
            watched[num_near++] = one;
            if (missing <= tolerance) continue;
            for (int c = 0; c < 3; ++c) {
                const int v = peaks_->triangles(one.foot.triangle, c);
                const double length = ahead * missing, known = pushes.row(v).norm();
                if (one.foot.barycentric[c] < least_part || length <= known) continue;
                if (known == 0.0) pushed.push_back(v);
                pushes.row(v) = length * one.foot.outwards;
            }
        }
        watched.resize(num_near);
        if (pushed.empty()) break;
        std::fill(moved.begin(), moved.end(), 0);
        for (const int v : peaks_->spread.spread(pushed, width, pushes)) {
            bone_wrap.row(v) += pushes.row(v);
            pushes.row(v).setZero();
            moved[v] = 1;
        }
    }
}

}  // namespace ndg
