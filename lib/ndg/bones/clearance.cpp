// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/clearance.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace ndg {

namespace {

constexpr double margin = 0.0015;      ///< m between bone and wrap that is kept in poses
constexpr double grid_margin = 0.006;  ///< m around a bone in which its distance is known
constexpr double spacing = 0.003;      ///< m
constexpr double least_share = 0.03;   ///< of a bone in a probe, below which it is not looked at
constexpr double peak_cell = 0.006;    ///< m
constexpr double folded_share = 0.3;   ///< of a bone in a probe, below which it counts as foreign

Eigen::RowVector3d area_normal(const Points& wrap, const Eigen::Ref<const Eigen::RowVector3i>& triangle)
{
    const Eigen::RowVector3d a = wrap.row(triangle[0]);
    return (wrap.row(triangle[1]) - a).cross(wrap.row(triangle[2]) - a);
}

/// Where on the wrap a point lies.
struct Foot {
    int triangle;
    Eigen::Vector3d barycentric;
    Eigen::RowVector3d outwards;  ///< of length 1, along the line to the point
    double height;                ///< of the point, negative inside
    bool at_rim;                  ///< where the wrap ends, so that there is no inside
};

/// The place nearest to a point as found by going over the wrap from a triangle: a bone that slides under the wrap is
/// followed, and another fold of the wrap that touches this one is not taken for it.
Foot find_foot(const WrapProbes& probes, const Points& wrap, const Eigen::Vector3d& point, int start)
{
    constexpr int most_steps = 12;
    const auto closest_on = [&](int t) {
        const auto triangle = probes.wrap_triangles.row(t);
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
            for (const int t : probes.triangles_of[probes.wrap_triangles(centre, c)]) {
                if (t == centre) continue;
                const ClosestPoint other = closest_on(t);
                if (other.distance < best.distance) best = other;
            }
    }
    const auto corners = probes.wrap_triangles.row(best.triangle_idx);
    Foot foot{best.triangle_idx, best.barycentric, area_normal(wrap, corners), 0.0, false};
    if (best.barycentric.minCoeff() < 1e-6) {
        // On an edge or at a corner: the mean of what meets there.
        foot.outwards.setZero();
        foot.at_rim = true;
        for (int c = 0; c < 3; ++c) {
            if (best.barycentric[c] < 1e-6) continue;
            foot.at_rim = foot.at_rim && probes.at_rim[corners[c]] != 0;
            for (const int t : probes.triangles_of[corners[c]])
                foot.outwards += best.barycentric[c] * area_normal(wrap, probes.wrap_triangles.row(t)).normalized();
        }
    }
    const Eigen::RowVector3d line = (point - best.point).transpose();
    const bool outside = line.dot(foot.outwards) > 0.0;
    foot.height = outside ? best.distance : -best.distance;
    constexpr double touching = 1e-6;  // m
    if (best.distance > touching) foot.outwards = outside ? line : Eigen::RowVector3d(-line);
    foot.outwards /= std::max(foot.outwards.norm(), 1e-20);
    return foot;
}

/// Normals of vertices of a wrap, those that are asked for.
class Normals {
public:
    Normals(const WrapProbes& probes, const Points& wrap)
        : probes_(probes), wrap_(wrap), normals_(wrap.rows(), 3), known_(wrap.rows(), 0)
    {
    }
    Eigen::RowVector3d of(int v)
    {
        if (known_[v] == 0) {
            known_[v] = 1;
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (const int t : probes_.triangles_of[v]) sum += area_normal(wrap_, probes_.wrap_triangles.row(t));
            normals_.row(v) = sum / std::max(sum.norm(), 1e-20);
        }
        return normals_.row(v);
    }

private:
    const WrapProbes& probes_;
    const Points wrap_;  ///< as it was before anything is pushed
    Points normals_;
    std::vector<char> known_;
};

}  // namespace

WrapProbes::WrapProbes(const BoneList& list, const Template& body_template, const BoneWeights& bone_weights)
    : wrap_triangles(body_template.wrap_triangles)
{
    std::map<std::pair<int, int>, int> known_pairs;
    const auto pair_of = [&](int vertex, int segment) {
        const auto [known, is_new] = known_pairs.try_emplace({vertex, segment}, int(pairs.size()));
        if (is_new) pairs.push_back({vertex, segment});
        return known->second;
    };
    for (int v = 0; v < bone_weights.size(); ++v) {
        if (bone_weights.begins[v + 1] - bone_weights.begins[v] < 2) continue;
        for (int k = bone_weights.begins[v]; k < bone_weights.begins[v + 1]; ++k)
            if (bone_weights.weights[k] >= least_share)
                probes.push_back({pair_of(v, bone_weights.segments[k]), float(bone_weights.weights[k])});
    }

    constexpr double deepest = 0.020;  // m below the wrap at rest; what lies deeper does not come out
    constexpr double own = 0.98;       // weight from which on a vertex moves with the bone
    const auto rides_on = [&](int v, int segment) {
        for (int k = bone_weights.begins[v]; k < bone_weights.begins[v + 1]; ++k)
            if (bone_weights.segments[k] == segment) return bone_weights.weights[k] >= own;
        return false;
    };
    const int num_wrap = body_template.num_wrap_vertices();
    triangles_of.resize(num_wrap);
    at_rim.assign(num_wrap, 0);
    for (int t = 0; t < int(wrap_triangles.rows()); ++t)
        for (int k = 0; k < 3; ++k) triangles_of[wrap_triangles(t, k)].push_back(t);
    const Points wrap = body_template.rest.volume_vertices.topRows(num_wrap);
    const TriangleTree tree(wrap, wrap_triangles);
    std::vector<std::array<int, 4>> beside(wrap_triangles.rows());
    for (std::size_t t = 0; t < beside.size(); ++t) beside[t].fill(int(t));
    std::vector<int> count(beside.size(), 1);
    for (const MeshEdge& edge : mesh_edges(wrap_triangles, num_wrap)) {
        if (edge.right_triangle < 0) {
            at_rim[edge.v0] = at_rim[edge.v1] = 1;
            continue;
        }
        beside[edge.left_triangle][std::size_t(count[edge.left_triangle]++)] = edge.right_triangle;
        beside[edge.right_triangle][std::size_t(count[edge.right_triangle]++)] = edge.left_triangle;
    }
    // Of the vertices in a cell of the bone the one nearest to the wrap stands for all.
    struct Candidate {
        int vertex, triangle;
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
            for (const int t : beside[closest.triangle_idx])
                for (int k = 0; k < 3; ++k) rides = rides && rides_on(wrap_triangles(t, k), bone.segment);
            if (rides) continue;
            const Eigen::Array3i c = (point / peak_cell).array().floor().cast<int>();
            const Candidate candidate{v, closest.triangle_idx, closest.distance};
            const auto [known, is_new] = nearest.try_emplace({bone.segment, c[0], c[1], c[2]}, candidate);
            if (!is_new && candidate.distance < known->second.distance) known->second = candidate;
        }
    for (const auto& [cell, candidate] : nearest) {
        Peak peak{candidate.vertex, candidate.triangle, {}};
        for (int k = 0; k < 3; ++k)
            peak.pairs[std::size_t(k)] = pair_of(wrap_triangles(candidate.triangle, k), std::get<0>(cell));
        peaks.push_back(peak);
    }
}

BoneClearance::BoneClearance(const WrapProbes& probes, const BoneList& list, const Template& body_template,
                             const Eigen::Ref<const Points>& anatomy_rest, const Eigen::Ref<const Points>& bone_wrap)
    : probes_(&probes), distances_(list.num_segments)
{
#pragma omp parallel for schedule(dynamic)
    for (int s = 0; s < list.num_segments; ++s) {
        std::vector<Eigen::RowVector3i> triangles;
        Points corners(2, 3);
        Eigen::AlignedBox3d box;
        for (const BoneList::Bone& bone : list.bones) {
            if (bone.segment != s) continue;
            for (int t = bone.triangle_begin; t < bone.triangle_end; ++t)
                triangles.push_back(body_template.anatomy_triangles.row(t));
            for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) box.extend(anatomy_rest.row(v).transpose());
        }
        corners.row(0) = box.min().transpose();
        corners.row(1) = box.max().transpose();
        Triangles surface(Eigen::Index(triangles.size()), 3);
        for (std::size_t t = 0; t < triangles.size(); ++t) surface.row(Eigen::Index(t)) = triangles[t];
        distances_[s] = signed_distance_grid(grid_around(corners, grid_margin, spacing), anatomy_rest, surface);
    }
    const Points wrap = bone_wrap;
    for (const WrapProbes::Probe& probe : probes.probes) {
        const WrapProbes::Pair& pair = probes.pairs[probe.pair];
        const Eigen::Vector3d at = wrap.row(pair.vertex).transpose();
        const ScalarGrid& grid = distances_[pair.segment];
        const Eigen::Vector3d last = grid.box.node(grid.box.size[0] - 1, grid.box.size[1] - 1, grid.box.size[2] - 1);
        // Outside the grid no bone is nearer than its box, from which the grid stands off.
        const double outside = Eigen::AlignedBox3d(grid.box.origin, last).exteriorDistance(at);
        const float distance = float(outside > 0.0 ? outside + 0.5 * grid_margin : grid.at(at));
        least_.push_back(std::min(float(margin), distance));
        spare_.push_back(distance - least_.back());
    }
    peaks_.resize(Eigen::Index(probes.peaks.size()), 3);
    for (std::size_t i = 0; i < probes.peaks.size(); ++i) {
        const WrapProbes::Peak& peak = probes.peaks[i];
        peaks_.row(Eigen::Index(i)) = anatomy_rest.row(peak.anatomy_vertex);
        const Foot foot = find_foot(probes, wrap, peaks_.row(Eigen::Index(i)).transpose(), peak.triangle);
        peak_triangles_.push_back(foot.triangle);
        allowed_.push_back(std::max(-0.5 * margin, foot.height));
        peak_spare_.push_back(float(allowed_.back() - foot.height));
    }
}

void BoneClearance::push_out(const Eigen::Ref<const Points>& rest_wrap, const std::vector<Eigen::Isometry3d>& segments,
                             Points& bone_wrap) const
{
    constexpr int iterations = 6, rings = 2;
    constexpr double most = 0.015;  // m, a step
    constexpr double least_slope = 0.3;
    constexpr double taken_along = 0.5;
    constexpr float watched = 0.0015F;    // m; what is farther from coming through at first does not come through later
    constexpr double tolerance = 0.0002;  // m, once pushed; less than what peaks keep
    const std::vector<WrapProbes::Pair>& pairs = probes_->pairs;
    // How far a vertex of the wrap is from where a segment would take it: its distance to the bone changes by no more.
    std::vector<Eigen::Matrix<float, 3, 4>> motions;
    std::vector<Eigen::Isometry3d> rest_from_world;
    for (const Eigen::Isometry3d& motion : segments) {
        motions.push_back(motion.matrix().topRows<3>().cast<float>());
        rest_from_world.push_back(motion.inverse());
    }
    std::vector<float> ways(pairs.size());
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Eigen::Vector3f rest = rest_wrap.row(pairs[i].vertex).transpose().cast<float>(),
                              now = bone_wrap.row(pairs[i].vertex).transpose().cast<float>();
        const Eigen::Matrix<float, 3, 4>& motion = motions[pairs[i].segment];
        ways[i] = (motion.leftCols<3>() * rest + motion.col(3) - now).norm();
    }

    Normals normals(*probes_, bone_wrap);
    Points pushes = Points::Zero(bone_wrap.rows(), 3);
    std::vector<int> pushed;
    const auto push = [&](int v, const Eigen::RowVector3d& by) {
        if (by.squaredNorm() <= pushes.row(v).squaredNorm()) return;
        if (pushes.row(v).isZero(0.0)) pushed.push_back(v);
        pushes.row(v) = by;
    };
    // A probe, a peak: true where it is worth looking again.
    const auto meet = [&](std::size_t i, double ignored) {
        const auto [v, s] = pairs[probes_->probes[i].pair];
        const ScalarGrid& grid = distances_[s];
        const Eigen::Vector3d at_rest = rest_from_world[s] * bone_wrap.row(v).transpose();
        const Eigen::Array3d in_grid = (at_rest - grid.box.origin).array() / grid.box.spacing;
        if ((in_grid < 0.0).any() || (in_grid > grid.box.size.cast<double>() - 1.0).any()) return false;
        Eigen::Vector3d gradient;
        const double missing = double(least_[i]) - grid.at(at_rest, &gradient);
        if (missing <= ignored) return missing > -watched;
        const Eigen::RowVector3d normal = normals.of(v);
        const double slope = normal.dot(segments[s].linear() * gradient);
        // A bone that the vertex hardly belongs to and that comes from outside: a fold, where the wrap touches itself.
        if (slope >= 0.0 || probes_->probes[i].share >= folded_share)
            push(v, std::min(missing / std::max(slope, least_slope), most) * normal);
        return true;
    };
    std::vector<int> triangles = peak_triangles_;
    const auto rise = [&](std::size_t i, double ignored) {
        const int segment = pairs[probes_->peaks[i].pairs[0]].segment;
        const Eigen::Vector3d point = segments[segment] * peaks_.row(Eigen::Index(i)).transpose();
        const Foot foot = find_foot(*probes_, bone_wrap, point, triangles[i]);
        triangles[i] = foot.triangle;
        if (foot.at_rim) return false;
        const double missing = foot.height - allowed_[i];
        if (missing <= ignored) return missing > -watched;
        const double share = std::min(missing, most) / foot.barycentric.squaredNorm();
        for (int c = 0; c < 3; ++c)
            push(probes_->wrap_triangles(foot.triangle, c), foot.barycentric[c] * share * foot.outwards);
        return true;
    };

    // The first look at all of them is the only long one.
    std::vector<std::size_t> meetings, peaks;
    for (std::size_t i = 0; i < probes_->probes.size(); ++i)
        if (spare_[i] - watched <= ways[probes_->probes[i].pair] && meet(i, 0.0)) meetings.push_back(i);
    for (std::size_t i = 0; i < probes_->peaks.size(); ++i) {
        const std::array<int, 3>& corners = probes_->peaks[i].pairs;
        if (peak_spare_[i] < std::max({ways[corners[0]], ways[corners[1]], ways[corners[2]]}) && rise(i, 0.0))
            peaks.push_back(i);
    }
    for (int iteration = 1;; ++iteration) {
        // Neighbours go along a part of the way, so that no vertex stands out alone.
        for (int ring = 0; ring < rings; ++ring) {
            const std::vector<int> sources = pushed;
            for (const int source : sources) {
                const Eigen::RowVector3d part = taken_along * pushes.row(source);
                for (const int t : probes_->triangles_of[source])
                    for (int c = 0; c < 3; ++c) push(probes_->wrap_triangles(t, c), part);
            }
        }
        for (const int v : pushed) {
            bone_wrap.row(v) += pushes.row(v);
            pushes.row(v).setZero();
        }
        if (iteration == iterations || pushed.empty()) break;
        pushed.clear();
        for (const std::size_t i : meetings) meet(i, tolerance);
        for (const std::size_t i : peaks) rise(i, tolerance);
    }
}

}  // namespace ndg
