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

Eigen::Vector3d place(const WrapProbes::Probe& probe, const Points& wrap)
{
    return ((wrap.row(probe.vertices[0]) + wrap.row(probe.vertices[1]) + wrap.row(probe.vertices[2])) / 3.0)
        .transpose();
}

/// A point as seen from a triangle: height over its plane, barycentric coordinates of its foot.
struct OverTriangle {
    Eigen::RowVector3d normal;
    Eigen::Vector3d barycentric;
    double height;
};

OverTriangle over_triangle(const Eigen::RowVector3d& point, const Points& wrap, const Eigen::RowVector3i& triangle)
{
    const Eigen::RowVector3d a = wrap.row(triangle[0]), ab = wrap.row(triangle[1]) - a, ac = wrap.row(triangle[2]) - a;
    const Eigen::RowVector3d ap = point - a, cross = ab.cross(ac);
    const double squared = std::max(cross.squaredNorm(), 1e-20);
    OverTriangle over;
    over.barycentric[1] = ap.cross(ac).dot(cross) / squared;
    over.barycentric[2] = ab.cross(ap).dot(cross) / squared;
    over.barycentric[0] = 1.0 - over.barycentric[1] - over.barycentric[2];
    over.normal = cross / std::sqrt(squared);
    over.height = ap.dot(over.normal);
    return over;
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
            for (const int t : probes_.triangles_of[v]) {
                const auto triangle = probes_.wrap_triangles.row(t);
                const Eigen::RowVector3d a = wrap_.row(triangle[0]);
                sum += (wrap_.row(triangle[1]) - a).cross(wrap_.row(triangle[2]) - a);
            }
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
    const auto add = [&](std::array<int, 3> vertices) {
        std::map<int, double> met;
        for (const int v : vertices)
            for (int k = bone_weights.begins[v]; k < bone_weights.begins[v + 1]; ++k)
                met[bone_weights.segments[k]] += bone_weights.weights[k] / 3.0;
        if (met.size() < 2) return;
        probes.push_back({vertices, int(segments.size()), 0});
        for (const auto& [segment, share] : met) {
            if (share < least_share) continue;
            segments.push_back(segment);
            shares.push_back(float(share));
        }
        probes.back().end = int(segments.size());
    };
    for (int v = 0; v < bone_weights.size(); ++v) add({v, v, v});
    for (Eigen::Index t = 0; t < wrap_triangles.rows(); ++t)
        add({wrap_triangles(t, 0), wrap_triangles(t, 1), wrap_triangles(t, 2)});

    constexpr double deepest = 0.015;  // m below the wrap at rest; what lies deeper does not come out
    constexpr double own = 0.98;       // weight from which on a vertex moves with the bone
    const auto rides_on = [&](int v, int segment) {
        for (int k = bone_weights.begins[v]; k < bone_weights.begins[v + 1]; ++k)
            if (bone_weights.segments[k] == segment) return bone_weights.weights[k] >= own;
        return false;
    };
    const int num_wrap = body_template.num_wrap_vertices();
    triangles_of.resize(num_wrap);
    for (int t = 0; t < int(wrap_triangles.rows()); ++t)
        for (int k = 0; k < 3; ++k) triangles_of[wrap_triangles(t, k)].push_back(t);
    const Points wrap = body_template.rest.volume_vertices.topRows(num_wrap);
    const TriangleTree tree(wrap, wrap_triangles);
    std::vector<std::array<int, 4>> beside(wrap_triangles.rows());
    for (std::size_t t = 0; t < beside.size(); ++t) beside[t].fill(int(t));
    std::vector<int> count(beside.size(), 1);
    for (const MeshEdge& edge : mesh_edges(wrap_triangles, num_wrap)) {
        if (edge.right_triangle < 0) continue;
        beside[edge.left_triangle][std::size_t(count[edge.left_triangle]++)] = edge.right_triangle;
        beside[edge.right_triangle][std::size_t(count[edge.right_triangle]++)] = edge.left_triangle;
    }
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
            for (const int t : beside[closest.triangle_idx])
                for (int k = 0; k < 3; ++k) rides = rides && rides_on(wrap_triangles(t, k), bone.segment);
            if (rides) continue;
            const Eigen::Array3i c = (point / peak_cell).array().floor().cast<int>();
            const Candidate candidate{{v, bone.segment, beside[closest.triangle_idx]}, closest.distance};
            const auto [known, is_new] = nearest.try_emplace({bone.segment, c[0], c[1], c[2]}, candidate);
            if (!is_new && candidate.distance < known->second.distance) known->second = candidate;
        }
    for (const auto& [cell, candidate] : nearest) peaks.push_back(candidate.peak);
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
    least_.resize(probes.segments.size());
    rest_distances_.resize(probes.segments.size());
    rest_places_.resize(Eigen::Index(probes.probes.size()), 3);
    for (std::size_t p = 0; p < probes.probes.size(); ++p) {
        const WrapProbes::Probe& probe = probes.probes[p];
        const Eigen::Vector3d at = place(probe, wrap);
        rest_places_.row(Eigen::Index(p)) = at.transpose();
        for (int k = probe.begin; k < probe.end; ++k) {
            const ScalarGrid& grid = distances_[probes.segments[k]];
            const Eigen::Vector3d last =
                grid.box.node(grid.box.size[0] - 1, grid.box.size[1] - 1, grid.box.size[2] - 1);
            // Outside the grid no bone is nearer than its box, from which the grid stands off.
            const double outside = Eigen::AlignedBox3d(grid.box.origin, last).exteriorDistance(at);
            rest_distances_[k] = float(outside > 0.0 ? outside + 0.5 * grid_margin : grid.at(at));
            least_[k] = float(std::min(margin, double(rest_distances_[k])));
        }
    }
    peaks_.resize(Eigen::Index(probes.peaks.size()), 3);
    for (std::size_t i = 0; i < probes.peaks.size(); ++i) {
        const WrapProbes::Peak& peak = probes.peaks[i];
        peaks_.row(Eigen::Index(i)) = anatomy_rest.row(peak.anatomy_vertex);
        std::array<float, 4> heights;
        for (std::size_t k = 0; k < 4; ++k) {
            const auto over =
                over_triangle(peaks_.row(Eigen::Index(i)), wrap, probes.wrap_triangles.row(peak.triangles[k]));
            heights[k] = float(std::max(-0.5 * margin, over.height));
            if (k == 0) peak_depths_.push_back(float(heights[k] - over.height));
        }
        peak_heights_.push_back(heights);
    }
}

void BoneClearance::push_out(const Eigen::Ref<const Points>& rest_wrap, const std::vector<Eigen::Isometry3d>& segments,
                             Points& bone_wrap) const
{
    constexpr int iterations = 4;
    constexpr double most = 0.015;  // m, a step
    constexpr double least_slope = 0.3, foot_slack = 0.1;
    constexpr double taken_along = 0.4;
    constexpr double watched = 0.0015;  // m; what is farther from coming through at first does not come through later
    std::vector<Eigen::Isometry3d> rest_from_world;
    for (const Eigen::Isometry3d& motion : segments) rest_from_world.push_back(motion.inverse());
    Normals normals(*probes_, bone_wrap);
    Points pushes = Points::Zero(bone_wrap.rows(), 3);
    std::vector<int> pushed;
    const auto push = [&](int v, const Eigen::RowVector3d& by) {
        if (by.squaredNorm() <= pushes.row(v).squaredNorm()) return;
        if (pushes.row(v).isZero(0.0)) pushed.push_back(v);
        pushes.row(v) = by;
    };

    // How far a point of the wrap is from where a segment would take it: its distance to the bone changes by no more.
    const auto way = [&](int segment, const Eigen::Vector3d& rest, const Eigen::Vector3d& now) {
        return (segments[segment].linear() * rest + segments[segment].translation() - now).norm();
    };
    // One segment met by one probe at a point, one peak under its triangles: true where it is worth looking again.
    const auto meet = [&](const WrapProbes::Probe& probe, int k, const Eigen::Vector3d& point) {
        const int s = probes_->segments[k];
        const ScalarGrid& grid = distances_[s];
        const Eigen::Vector3d at_rest = rest_from_world[s] * point;
        const Eigen::Vector3d in_grid = (at_rest - grid.box.origin) / grid.box.spacing;
        if ((in_grid.array() < 0.0).any() || (in_grid.array() > grid.box.size.cast<double>() - 1.0).any()) return false;
        const double missing = least_[k] - grid.at(at_rest);
        if (missing <= 0.0) return missing > -watched;
        Eigen::Vector3d gradient;
        grid.at(at_rest, &gradient);
        const Eigen::Vector3d away = segments[s].linear() * gradient;
        for (const int v : probe.vertices) {
            const Eigen::RowVector3d normal = normals.of(v);
            const double slope = normal.dot(away);
            // A bone that the vertex hardly belongs to and that comes from outside: a fold, where the wrap touches
            // itself.
            if (slope < 0.0 && probes_->shares[k] < folded_share) continue;
            push(v, std::min(missing / std::max(slope, least_slope), most) * normal);
        }
        return true;
    };
    const auto rise = [&](std::size_t i) {
        const WrapProbes::Peak& peak = probes_->peaks[i];
        const Eigen::RowVector3d point = (segments[peak.segment] * peaks_.row(Eigen::Index(i)).transpose()).transpose();
        bool near = false;
        for (std::size_t k = 0; k < 4; ++k) {
            const auto triangle = probes_->wrap_triangles.row(peak.triangles[k]);
            const OverTriangle over = over_triangle(point, bone_wrap, triangle);
            const double missing = over.height - peak_heights_[i][k];
            near = near || missing > -watched;
            if (missing <= 0.0 || over.barycentric.minCoeff() < -foot_slack) continue;
            const double share = std::min(missing, most) / over.barycentric.squaredNorm();
            for (int c = 0; c < 3; ++c)
                push(triangle[c], std::clamp(over.barycentric[c], 0.0, 1.0) * share * over.normal);
        }
        return near;
    };

    // The first look at all of them is the only long one; what it finds is taken in order.
    std::vector<char> near_probes(probes_->segments.size(), 0), near_peaks(probes_->peaks.size(), 0);
#pragma omp parallel
    {
#pragma omp for schedule(static) nowait
        for (int p = 0; p < int(probes_->probes.size()); ++p) {
            const WrapProbes::Probe& probe = probes_->probes[p];
            const Eigen::Vector3d point = place(probe, bone_wrap), rest = rest_places_.row(p).transpose();
            for (int k = probe.begin; k < probe.end; ++k)
                near_probes[k] = rest_distances_[k] - least_[k] - watched <= way(probes_->segments[k], rest, point);
        }
#pragma omp for schedule(static)
        for (int i = 0; i < int(probes_->peaks.size()); ++i) {
            const WrapProbes::Peak& peak = probes_->peaks[i];
            double farthest = 0.0;
            for (int c = 0; c < 3; ++c) {
                const int v = probes_->wrap_triangles(peak.triangles[0], c);
                farthest =
                    std::max(farthest, way(peak.segment, rest_wrap.row(v).transpose(), bone_wrap.row(v).transpose()));
            }
            near_peaks[i] = peak_depths_[i] < farthest;
        }
    }
    std::vector<std::pair<int, int>> meetings;  // probe and place of the segment
    std::vector<int> peaks;
    for (int p = 0; p < int(probes_->probes.size()); ++p) {
        const WrapProbes::Probe& probe = probes_->probes[p];
        for (int k = probe.begin; k < probe.end; ++k)
            if (near_probes[k] != 0 && meet(probe, k, place(probe, bone_wrap))) meetings.emplace_back(p, k);
    }
    for (int i = 0; i < int(probes_->peaks.size()); ++i)
        if (near_peaks[i] != 0 && rise(std::size_t(i))) peaks.push_back(i);
    for (int iteration = 1;; ++iteration) {
        // Neighbours go along a part of the way, so that no vertex stands out alone.
        const std::vector<int> sources = pushed;
        for (const int source : sources) {
            const Eigen::RowVector3d part = taken_along * pushes.row(source);
            for (const int t : probes_->triangles_of[source])
                for (int c = 0; c < 3; ++c) push(probes_->wrap_triangles(t, c), part);
        }
        for (const int v : pushed) {
            bone_wrap.row(v) += pushes.row(v);
            pushes.row(v).setZero();
        }
        if (iteration == iterations || pushed.empty()) break;
        pushed.clear();
        for (const auto& [p, k] : meetings) meet(probes_->probes[p], k, place(probes_->probes[p], bone_wrap));
        for (const int i : peaks) rise(std::size_t(i));
    }
}

}  // namespace ndg
