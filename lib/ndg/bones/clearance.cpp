// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/clearance.h"

#include "ndg/geometry/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace ndg {

namespace {

constexpr float near = 0.003F;        // m: what is farther from coming through at first does not come through later
constexpr float tolerance = 0.0003F;  // m

/// First the wrap moves over a large width about what came through, then over less and less, m.
std::vector<double> widths_of_passes()
{
    constexpr double widest = 0.060, narrowest = 0.013, narrowing = 0.85;
    constexpr int passes = 12;
    std::vector<double> widths;
    for (int pass = 0; pass < passes; ++pass) widths.push_back(std::max(widest * std::pow(narrowing, pass), narrowest));
    return widths;
}

}  // namespace

WrapPeaks::WrapPeaks(const BoneList& list, const Template& body_template, const BoneWeights& weights)
    : surface(body_template.wrap_triangles, body_template.num_wrap_vertices()),
      spread(body_template.rest.volume_vertices.topRows(body_template.num_wrap_vertices()), surface.triangles,
             widths_of_passes())
{
    constexpr double deepest = 0.020;  // m below the wrap at rest; what lies deeper does not come out
    constexpr double cell = 0.003, shallow = 0.008, cell_below = 0.006;  // m; cells of bones down to a depth, and below
    constexpr double thin = 0.010;  // m: so far behind a bone its wrap is looked for on the other side
    constexpr double own = 0.98;    // weight from which on a vertex moves with the bone
    const auto rides_on = [&](int v, int segment) {
        for (int k = weights.begins[v]; k < weights.begins[v + 1]; ++k)
            if (weights.segments[k] == segment) return weights.weights[k] >= own;
        return false;
    };
    const Triangles& triangles = surface.triangles;
    const TriangleTree tree(body_template.rest.volume_vertices.topRows(body_template.num_wrap_vertices()), triangles);
    // Of the vertices in a cell of the bone the one nearest to the wrap stands for all.
    struct Candidate {
        Peak peak;
        double distance;
    };
    std::map<std::tuple<int, int, int, int, int>, Candidate> nearest;
    const auto add = [&](int v, int segment, int side, int triangle, double distance) {
        if (distance > deepest) return;
        bool rides = true;
        for (int c = 0; c < 3; ++c)
            for (const int t : surface.triangles_of[triangles(triangle, c)])
                for (int k = 0; k < 3; ++k) rides = rides && rides_on(triangles(t, k), segment);
        if (rides) return;
        const bool is_shallow = distance < shallow;
        const Eigen::Array3i c = (body_template.anatomy_vertices.row(v) / (is_shallow ? cell : cell_below))
                                     .array()
                                     .floor()
                                     .cast<int>()
                                     .transpose();
        const Candidate candidate{{v, segment, triangle}, distance};
        const auto [known, is_new] =
            nearest.try_emplace({segment, 2 * side + int(is_shallow), c[0], c[1], c[2]}, candidate);
        if (!is_new && candidate.distance < known->second.distance) known->second = candidate;
    };
    for (const BoneList::Bone& bone : list.bones)
        for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) {
            if (body_template.embedding.elements[v] < 0) continue;
            const Eigen::Vector3d point = body_template.anatomy_vertices.row(v).transpose();
            const ClosestPoint closest = tree.closest(point);
            add(v, bone.segment, 0, closest.triangle_idx, closest.distance);
            // The tip of a rib lies in a tongue of the wrap and may come through on its other side.
            const Eigen::Vector3d away = (point - closest.point).normalized();
            const ClosestPoint behind = tree.closest(point + thin * away);
            const Eigen::Vector3d to_behind = behind.point - point;
            if (to_behind.dot(away) > 0.0) add(v, bone.segment, 1, behind.triangle_idx, to_behind.norm());
        }
    segment_begins.assign(list.num_segments + 1, 0);
    for (const auto& [place, candidate] : nearest) {
        peaks.push_back(candidate.peak);
        segment_begins[candidate.peak.segment + 1] = int(peaks.size());
    }
    for (int s = 0; s < list.num_segments; ++s)
        segment_begins[s + 1] = std::max(segment_begins[s + 1], segment_begins[s]);
}

BoneClearance::BoneClearance(const WrapPeaks& peaks, const Eigen::Ref<const Points>& anatomy_rest,
                             const Eigen::Ref<const Points>& bone_wrap)
    : peaks_(&peaks)
{
    constexpr float kept = 0.0004F;  // m between bone and wrap
    PointColumnsF rest_wrap = PointColumnsF::Zero(4, bone_wrap.rows());
    rest_wrap.topRows<3>() = bone_wrap.transpose().cast<float>();
    // Each segment fills its last lanes with one of its peaks that is never looked after.
    std::vector<int> peak_of;
    std::vector<char> fills;
    segment_begins_.push_back(0);
    for (std::size_t s = 0; s + 1 < peaks.segment_begins.size(); ++s) {
        for (int i = peaks.segment_begins[s]; i < peaks.segment_begins[s + 1]; ++i) peak_of.push_back(i);
        fills.resize(peak_of.size(), 0);
        while (peak_of.size() % LanesF::size() != 0) peak_of.push_back(peak_of.back());
        fills.resize(peak_of.size(), 1);
        segment_begins_.push_back(int(peak_of.size()));
    }
    rest_.resize(int(peak_of.size()));
    for (int i = 0; i < rest_.size(); ++i) {
        const WrapPeaks::Peak& peak = peaks.peaks[peak_of[i]];
        for (int axis = 0; axis < 3; ++axis)
            rest_.axes[std::size_t(axis)][i] = float(anatomy_rest(peak.anatomy_vertex, axis));
        rest_.allowed[i] = -kept;
        rest_.triangles[i] = peak.triangle;
    }
    follow(peaks.surface, rest_wrap, std::vector<char>(std::size_t(bone_wrap.rows()), 1), 0, rest_.size(), rest_);
    rest_.feet.clear();
    for (int i = 0; i < rest_.size(); ++i) {
        rest_.allowed[i] = std::max(-kept, rest_.heights[i]);
        spare_.push_back(fills[i] ? std::numeric_limits<float>::infinity() : rest_.allowed[i] - rest_.heights[i]);
        for (std::size_t c = 0; c < 3; ++c) {
            const int v = peaks.surface.triangles(rest_.triangles[i], Eigen::Index(c));
            corners_[c].push_back(v);
            for (std::size_t axis = 0; axis < 3; ++axis)
                rest_corners_[3 * c + axis].push_back(rest_wrap(Eigen::Index(axis), v));
        }
    }
}

/// Kept by each thread between calls, so that none of them allocates.
struct BoneClearance::Scratch {
    explicit Scratch(const SurfaceSpread& spread) : pushes(spread) {}

    PointColumnsF wrap;
    std::array<std::vector<float>, 3> points;  ///< of the peaks
    std::vector<float> may_come_through;       ///< 1 or 0
    std::vector<int> watched;
    FollowedPoints followed;
    std::vector<char> has_moved;  ///< of each vertex, in the last pass
    std::vector<char> ever_moved;
    SurfaceSpread::Pushes pushes;
};

/// Where the peaks are, and which of them may come through: not those that lie deep over the same triangle as at rest,
/// and of the others those under which the wrap moved against the bone by more than most of what is between them at
/// rest.
void BoneClearance::look_over(const std::vector<Eigen::Isometry3d>& segments, Scratch& scratch) const
{
    constexpr float most = 0.7F, least = 0.0002F;  // m
    for (std::vector<float>& axis : scratch.points) axis.resize(std::size_t(rest_.size()));
    scratch.may_come_through.resize(std::size_t(rest_.size()));
#pragma omp parallel for schedule(dynamic, 4)
    for (int s = 0; s < int(segment_begins_.size()) - 1; ++s) {
        const Eigen::Matrix<float, 3, 4> m = segments[s].matrix().topRows<3>().cast<float>();
        using Vector = std::array<LanesF, 3>;
        const auto carried = [&](int axis, const Vector& at) -> LanesF {
            const LanesF x = m(axis, 0) * at[0], y = m(axis, 1) * at[1], z = m(axis, 2) * at[2];
            return x + y + z + m(axis, 3);
        };
        for (int i = segment_begins_[s]; i < segment_begins_[s + 1]; i += int(LanesF::size())) {
            const Vector peak{load_lanes(&rest_.axes[0][i]), load_lanes(&rest_.axes[1][i]),
                              load_lanes(&rest_.axes[2][i])};
            const Vector point{carried(0, peak), carried(1, peak), carried(2, peak)};
            std::array<Vector, 3> corners;
            LanesF farthest = 0.0F;  // of the corners from where the bone would have carried them, squared
            for (std::size_t c = 0; c < 3; ++c) {
                corners[c] = vertex_lanes(scratch.wrap, [&](std::size_t lane) { return corners_[c][i + lane]; });
                const Vector rest{load_lanes(&rest_corners_[3 * c][i]), load_lanes(&rest_corners_[3 * c + 1][i]),
                                  load_lanes(&rest_corners_[3 * c + 2][i])};
                const Vector left_behind =
                    difference<LanesF>({carried(0, rest), carried(1, rest), carried(2, rest)}, corners[c]);
                farthest = max(farthest, dot(left_behind, left_behind));
            }
            const SeenTriangle<LanesF> seen(corners[0], corners[1], corners[2], point);
            const LanesF bound = most * load_lanes(&spare_[i]) + least, deep = load_lanes(&rest_.allowed[i]) - near;
            LanesF may_come_through = 1.0F;
            where((seen.least() >= 0.0F && seen.height <= deep) || farthest <= bound * bound, may_come_through) = 0.0F;
            store_lanes(may_come_through, &scratch.may_come_through[i]);
            for (std::size_t axis = 0; axis < 3; ++axis) store_lanes(point[axis], &scratch.points[axis][i]);
        }
    }
}

/// Keeps in view the peaks that may come through.
void BoneClearance::watch(Scratch& scratch) const
{
    std::vector<int>& watched = scratch.watched;
    watched.resize(std::size_t(rest_.size()));
    int count = 0;
    for (int i = 0; i < rest_.size(); ++i) {
        watched[count] = i;
        count += int(scratch.may_come_through[i]);
    }
    FollowedPoints& followed = scratch.followed;
    followed.resize(count);
    for (int k = 0; k < count; ++k) {
        const int i = watched[k];
        for (std::size_t axis = 0; axis < 3; ++axis) followed.axes[axis][k] = scratch.points[axis][i];
        followed.allowed[k] = rest_.allowed[i];
        followed.triangles[k] = rest_.triangles[i];
    }
}

/// Pushes of the wrap under what is too high; forgets what is not near. Whether there are any.
bool BoneClearance::pushes_of(Scratch& scratch) const
{
    constexpr float ahead = 1.2F;        // the first look's pushes are spread and come out less
    constexpr float least_part = 0.05F;  // of a corner under a peak, from which on it is pushed
    FollowedPoints& followed = scratch.followed;
    int num_near = 0;
    for (int k = 0; k < followed.size(); ++k) {
        const float missing = followed.heights[k] - followed.allowed[k];
        if (missing <= -near) continue;
        if (num_near < k) followed.copy(k, num_near);
        const WrapFoot& foot = followed.feet[num_near++];
        if (missing <= tolerance) continue;
        for (int c = 0; c < 3; ++c)
            if (foot.barycentric[c] >= least_part)
                scratch.pushes.add(peaks_->surface.triangles(foot.triangle, c), ahead * missing * foot.outwards);
    }
    followed.resize(num_near);
    return !scratch.pushes.empty();
}

void BoneClearance::push_out(const std::vector<Eigen::Isometry3d>& segments, Points& bone_wrap) const
{
    thread_local Scratch scratch_of_thread(peaks_->spread);
    Scratch& scratch = scratch_of_thread;  // of this thread, also in parallel loops
    const Eigen::Index num_vertices = bone_wrap.rows();
    scratch.wrap.resize(4, num_vertices);
#pragma omp parallel for schedule(static)
    for (Eigen::Index v = 0; v < num_vertices; ++v)
        scratch.wrap.col(v) << bone_wrap.row(v).transpose().cast<float>(), 0.0F;
    scratch.has_moved.assign(std::size_t(num_vertices), 1);
    scratch.ever_moved.assign(std::size_t(num_vertices), 0);
    scratch.pushes.reset(peaks_->spread);
    look_over(segments, scratch);
    watch(scratch);
    constexpr int block = 256;  // points
    for (int pass = 0; pass < peaks_->spread.num_widths(); ++pass) {
        const int count = scratch.followed.size();
#pragma omp parallel for schedule(dynamic) if (count > block)
        for (int first = 0; first < count; first += block)
            follow(peaks_->surface, scratch.wrap, scratch.has_moved, first, std::min(count, first + block),
                   scratch.followed);
        if (!pushes_of(scratch)) break;
        std::fill(scratch.has_moved.begin(), scratch.has_moved.end(), 0);
        for (const int v : peaks_->spread.spread(scratch.pushes, pass, scratch.wrap))
            scratch.has_moved[v] = scratch.ever_moved[v] = 1;
    }
#pragma omp parallel for schedule(static)
    for (Eigen::Index v = 0; v < num_vertices; ++v)
        if (scratch.ever_moved[v] != 0) bone_wrap.row(v) = scratch.wrap.col(v).head<3>().transpose().cast<double>();
}

}  // namespace ndg
