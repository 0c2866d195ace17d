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
    : peaks_(&peaks), rest_wrap_(PointColumnsF::Zero(4, bone_wrap.rows()))
{
    constexpr float kept = 0.0004F;  // m between bone and wrap
    rest_wrap_.topRows<3>() = bone_wrap.transpose().cast<float>();
    for (const WrapPeaks::Peak& peak : peaks.peaks) {
        const Eigen::Vector3f point = anatomy_rest.row(peak.anatomy_vertex).transpose().cast<float>();
        const WrapFoot foot = find_foot(peaks.surface, rest_wrap_, point, peak.triangle, -kept);
        triangles_.push_back(foot.triangle);
        allowed_.push_back(std::max(-kept, foot.height));
        spare_.push_back(allowed_.back() - foot.height);
        for (int c = 0; c < 3; ++c) {
            points_[std::size_t(c)].push_back(point[c]);
            corners_[std::size_t(c)].push_back(4 * peaks.surface.triangles(foot.triangle, c));
        }
    }
}

/// A peak that may come through.
struct BoneClearance::Watched {
    int peak;
    Eigen::Vector3f point;
    WrapFoot foot;
};

/// Kept by each thread between calls, so that none of them allocates.
struct BoneClearance::Scratch {
    explicit Scratch(const SurfaceSpread& spread) : pushes(spread) {}

    PointColumnsF wrap;
    std::array<std::vector<float>, 3> points;  ///< of the peaks
    std::vector<float> heights;                ///< over the triangle they lie over at rest; infinite: no longer over it
    std::vector<Watched> watched;
    std::vector<char> has_moved;  ///< of each vertex, in the last pass
    std::vector<char> ever_moved;
    SurfaceSpread::Pushes pushes;
};

/// Where the peaks are, and how high those that lie over the same triangle as at rest.
void BoneClearance::look_over(const std::vector<Eigen::Isometry3d>& segments, Scratch& scratch) const
{
    constexpr float elsewhere = std::numeric_limits<float>::infinity();
    const std::vector<int>& begins = peaks_->segment_begins;
    scratch.heights.resize(allowed_.size());
    for (std::vector<float>& axis : scratch.points) axis.resize(allowed_.size());
    const float *const x = points_[0].data(), *const y = points_[1].data(), *const z = points_[2].data();
    const int *const first_corner = corners_[0].data(), *const second_corner = corners_[1].data(),
                     *const third_corner = corners_[2].data();
    const float* const wrap = scratch.wrap.data();
    float *const now_x = scratch.points[0].data(), *const now_y = scratch.points[1].data(),
                 *const now_z = scratch.points[2].data(), *const heights = scratch.heights.data();
#pragma omp parallel for schedule(dynamic, 4)
    for (int s = 0; s < int(begins.size()) - 1; ++s) {
        const Eigen::Matrix<float, 3, 4> m = segments[s].matrix().topRows<3>().cast<float>();
#pragma omp simd
        for (int i = begins[s]; i < begins[s + 1]; ++i) {
            const float px = m(0, 0) * x[i] + m(0, 1) * y[i] + m(0, 2) * z[i] + m(0, 3);
            const float py = m(1, 0) * x[i] + m(1, 1) * y[i] + m(1, 2) * z[i] + m(1, 3);
            const float pz = m(2, 0) * x[i] + m(2, 1) * y[i] + m(2, 2) * z[i] + m(2, 3);
            now_x[i] = px;
            now_y[i] = py;
            now_z[i] = pz;
            const float *const a = wrap + first_corner[i], *const b = wrap + second_corner[i],
                               *const c = wrap + third_corner[i];
            const float ax = a[0], ay = a[1], az = a[2];
            const float ux = b[0] - ax, uy = b[1] - ay, uz = b[2] - az;
            const float vx = c[0] - ax, vy = c[1] - ay, vz = c[2] - az;
            const float dx = px - ax, dy = py - ay, dz = pz - az;
            const float nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
            const float area = nx * nx + ny * ny + nz * nz;
            const float wx = ny * dz - nz * dy, wy = nz * dx - nx * dz, wz = nx * dy - ny * dx;
            // Barycentric coordinates times area.
            const float second = wx * vx + wy * vy + wz * vz, third = -(wx * ux + wy * uy + wz * uz);
            const float least = std::min(std::min(second, third), area - second - third);
            const float height = (dx * nx + dy * ny + dz * nz) / std::sqrt(std::max(area, 1e-30F));
            heights[i] = least >= 0.0F ? height : elsewhere;
        }
    }
}

/// Keeps in view the peaks that are near coming through, and of those that lie elsewhere than at rest the ones under
/// which the wrap moved against the bone by more than most of what is between them at rest.
void BoneClearance::watch(const std::vector<Eigen::Isometry3d>& segments, Scratch& scratch) const
{
    constexpr float most = 0.7F, least = 0.0002F;  // m
    const std::vector<int>& begins = peaks_->segment_begins;
    scratch.watched.clear();
    for (int s = 0; s < int(begins.size()) - 1; ++s) {
        const Eigen::Matrix<float, 3, 4> motion = segments[s].matrix().topRows<3>().cast<float>();
        for (int i = begins[s]; i < begins[s + 1]; ++i) {
            if (scratch.heights[i] <= allowed_[i] - near) continue;
            const float bound = most * spare_[i] + least;
            const auto may_be_lower = [&](int c) {
                const Eigen::Index v = corners_[std::size_t(c)][i] / 4;
                const Eigen::Vector3f carried = motion.leftCols<3>() * rest_wrap_.col(v).head<3>() + motion.col(3);
                return (carried - scratch.wrap.col(v).head<3>()).squaredNorm() > bound * bound;
            };
            if (!may_be_lower(0) && !may_be_lower(1) && !may_be_lower(2)) continue;
            const Eigen::Vector3f point(scratch.points[0][i], scratch.points[1][i], scratch.points[2][i]);
            scratch.watched.push_back({i, point, {triangles_[i], 0.0F, {}, {}}});
        }
    }
}

/// Pushes of the wrap under what is too high; forgets what is not near. Whether there are any.
bool BoneClearance::pushes_of(Scratch& scratch) const
{
    constexpr float ahead = 1.2F;        // the first look's pushes are spread and come out less
    constexpr float least_part = 0.05F;  // of a corner under a peak, from which on it is pushed
    std::size_t num_near = 0;
    for (const Watched& one : scratch.watched) {
        const float missing = one.foot.height - allowed_[one.peak];
        if (missing <= -near) continue;
        scratch.watched[num_near++] = one;
        if (missing <= tolerance) continue;
        for (int c = 0; c < 3; ++c)
            if (one.foot.barycentric[c] >= least_part)
                scratch.pushes.add(peaks_->surface.triangles(one.foot.triangle, c),
                                   ahead * missing * one.foot.outwards);
    }
    scratch.watched.resize(num_near);
    return !scratch.pushes.empty();
}

void BoneClearance::push_out(const std::vector<Eigen::Isometry3d>& segments, Points& bone_wrap) const
{
    thread_local Scratch scratch_of_thread(peaks_->spread);
    Scratch& scratch = scratch_of_thread;  // of this thread, also in parallel loops
    const Eigen::Index num_vertices = bone_wrap.rows();
    scratch.wrap.setZero(4, num_vertices);
    scratch.wrap.topRows<3>() = bone_wrap.transpose().cast<float>();
    scratch.has_moved.assign(num_vertices, 1);
    scratch.ever_moved.assign(num_vertices, 0);
    scratch.pushes.reset(peaks_->spread);
    look_over(segments, scratch);
    watch(segments, scratch);
    for (int pass = 0; pass < peaks_->spread.num_widths(); ++pass) {
        std::vector<Watched>& watched = scratch.watched;
#pragma omp parallel for schedule(static) if (watched.size() > 256)
        for (std::size_t k = 0; k < watched.size(); ++k) {
            Watched& one = watched[k];
            const auto corners = peaks_->surface.triangles.row(one.foot.triangle);
            if (scratch.has_moved[corners[0]] == 0 && scratch.has_moved[corners[1]] == 0 &&
                scratch.has_moved[corners[2]] == 0)
                continue;
            one.foot = find_foot(peaks_->surface, scratch.wrap, one.point, one.foot.triangle, allowed_[one.peak]);
        }
        if (!pushes_of(scratch)) break;
        std::fill(scratch.has_moved.begin(), scratch.has_moved.end(), 0);
        for (const int v : peaks_->spread.spread(scratch.pushes, pass, scratch.wrap))
            scratch.has_moved[v] = scratch.ever_moved[v] = 1;
    }
    for (Eigen::Index v = 0; v < num_vertices; ++v)
        if (scratch.ever_moved[v] != 0) bone_wrap.row(v) = scratch.wrap.col(v).head<3>().transpose().cast<double>();
}

}  // namespace ndg
