// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/inner_surface.h"

#include "ndg/body/skeleton.h"
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace ndg {

namespace {

// Smoothing lengths along the surface, m; the number of averaging steps follows from the mesh's edge length.
constexpr double projection_smoothing = 0.09;        ///< averaging, then sliding back onto the skeleton
constexpr double final_projection_smoothing = 0.05;  ///< averaging alone, which rounds the corners of the skeleton
constexpr double share_smoothing = 0.08;
constexpr int max_repair_steps = 400;
constexpr double repair_shortening = 0.96;
constexpr double min_tissue_thickness = 0.003;  ///< m, of both layers together where they have to be repaired
constexpr double min_bone_weight = 0.15;        ///< a vertex hangs on a bone if its weight is at least this

struct BoneSegment {
    int owner;  ///< joint whose weights say who hangs on this bone
    Eigen::RowVector3d start, end;
};

/// Straight bones of the volumetric region.
std::vector<BoneSegment> bone_segments(const Eigen::Ref<const Points>& joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<BoneSegment> segments;
    const auto add = [&](const std::string& from, const std::string& to) {
        const int a = skeleton.joint(from), b = skeleton.joint(to);
        segments.push_back({a, joint_positions.row(a), joint_positions.row(b)});
    };
    const std::vector<std::string> trunk = {"pelvis",  "spine_1", "spine_2", "spine_3", "spine_4",
                                            "spine_5", "neck_1",  "neck_2",  "head"};
    for (std::size_t i = 0; i + 1 < trunk.size(); ++i) add(trunk[i], trunk[i + 1]);
    for (const std::string side : {"left_", "right_"}) {
        add("pelvis", side + "thigh");
        add(side + "clavicle", side + "upper_arm");
        add(side + "upper_arm", side + "forearm");
        add(side + "forearm", side + "forearm_twist");
        add(side + "forearm_twist", side + "hand");
        add(side + "hand", side + "middle_1");
        add(side + "thigh", side + "shin");
        add(side + "shin", side + "foot");
        add(side + "foot", side + "toes");
    }
    return segments;
}

Eigen::RowVector3d closest_on_segment(const BoneSegment& segment, const Eigen::RowVector3d& point)
{
    const Eigen::RowVector3d axis = segment.end - segment.start;
    const double t = std::clamp((point - segment.start).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    return segment.start + t * axis;
}

template <typename Accept>
Eigen::RowVector3d closest_on_skeleton(const std::vector<BoneSegment>& segments, const Eigen::RowVector3d& point,
                                       const Accept& accept)
{
    Eigen::RowVector3d best = point;
    double best_distance = std::numeric_limits<double>::max();
    for (const BoneSegment& segment : segments) {
        if (!accept(segment)) continue;
        const Eigen::RowVector3d candidate = closest_on_segment(segment, point);
        const double distance = (candidate - point).squaredNorm();
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

/// Averaging neighbours: vertices on the border of a cut average along the border alone, so that it is not pulled
/// inwards.
std::vector<std::vector<int>> smoothing_neighbours(const WrapSkin& skin)
{
    const int count = static_cast<int>(skin.vertices.rows());
    auto neighbours = vertex_neighbours(skin.triangles, count);
    for (const auto& loop : boundary_loops(skin.triangles, count))
        for (std::size_t i = 0; i < loop.size(); ++i)
            neighbours[loop[i]] = {loop[(i + 1) % loop.size()], loop[(i + loop.size() - 1) % loop.size()]};
    return neighbours;
}

/// Averaging over k neighbourhoods spreads over about sqrt(k) edges.
int smoothing_steps(const WrapSkin& skin, double length)
{
    double total = 0.0;
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k)
            total +=
                (skin.vertices.row(skin.triangles(t, k)) - skin.vertices.row(skin.triangles(t, (k + 1) % 3))).norm();
    const double edges = length / (total / (3.0 * static_cast<double>(skin.triangles.rows())));
    return std::max(1, static_cast<int>(std::lround(edges * edges)));
}

template <typename Matrix>
Matrix neighbour_mean(const Matrix& values, const std::vector<std::vector<int>>& neighbours)
{
    Matrix mean = values;
    for (std::size_t v = 0; v < neighbours.size(); ++v) {
        if (neighbours[v].empty()) continue;
        mean.row(v).setZero();
        for (const int n : neighbours[v]) mean.row(v) += values.row(n);
        mean.row(v) /= static_cast<double>(neighbours[v].size());
    }
    return mean;
}

/// Soft-tissue share by joint: our reading of cross-sections of the adult body (bone and cavity against the whole).
const std::map<std::string, double>& soft_tissue_share_by_joint()
{
    static const std::map<std::string, double> shares = {
        {"pelvis", 0.42},    {"spine_1", 0.38}, {"spine_2", 0.34},       {"spine_3", 0.30}, {"spine_4", 0.28},
        {"spine_5", 0.30},   {"neck_1", 0.50},  {"neck_2", 0.50},        {"head", 0.50},    {"clavicle", 0.42},
        {"upper_arm", 0.64}, {"forearm", 0.55}, {"forearm_twist", 0.48}, {"hand", 0.42},    {"thigh", 0.66},
        {"shin", 0.56},      {"foot", 0.42},    {"toes", 0.40}};
    return shares;
}

/// For each vertex the inward direction that its triangles see best: the smallest angle to any of their inward normals
/// is as large as a few steps of pushing away from the worst triangle make it. Along it, thin enough layers are valid.
Points visible_directions(const WrapSkin& skin)
{
    constexpr int steps = 50;
    const Points normals = triangle_normals(skin.vertices, skin.triangles);
    std::vector<std::vector<Eigen::Index>> triangles_of(skin.vertices.rows());
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) triangles_of[skin.triangles(t, k)].push_back(t);
    Points directions = -vertex_normals(skin.vertices, skin.triangles);
    for (Eigen::Index v = 0; v < directions.rows(); ++v)
        for (int step = 0; step < steps; ++step) {
            Eigen::Index worst = triangles_of[v].front();
            for (const Eigen::Index t : triangles_of[v])
                if (directions.row(v).dot(-normals.row(t)) < directions.row(v).dot(-normals.row(worst))) worst = t;
            directions.row(v) = (directions.row(v) - (1.0 / (step + 2.0)) * normals.row(worst)).normalized();
        }
    return directions;
}

PrismVertices stack_prism(const Eigen::Ref<const Points>& outer, const Eigen::Ref<const Points>& inner,
                          const Triangles& triangles, Eigen::Index t)
{
    PrismVertices prism;
    for (int k = 0; k < 3; ++k) {
        prism.row(k) = outer.row(triangles(t, k));
        prism.row(3 + k) = inner.row(triangles(t, k));
    }
    return prism;
}

}  // namespace

Points skeleton_projection(const WrapSkin& skin)
{
    const auto segments = bone_segments(skin.joint_positions);
    const auto neighbours = smoothing_neighbours(skin);
    const int sliding_steps = smoothing_steps(skin, projection_smoothing);
    const int final_steps = smoothing_steps(skin, final_projection_smoothing);
    const auto any = [](const BoneSegment&) { return true; };
    Points projection(skin.vertices.rows(), 3);
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        const double largest = skin.weights.row(v).maxCoeff();
        projection.row(v) = closest_on_skeleton(segments, skin.vertices.row(v), [&](const BoneSegment& segment) {
            return skin.weights(v, segment.owner) >= std::min(min_bone_weight, 0.5 * largest);
        });
    }
    for (int step = 0; step < sliding_steps; ++step) {
        const Points mean = neighbour_mean(projection, neighbours);
        for (Eigen::Index v = 0; v < projection.rows(); ++v)
            projection.row(v) = closest_on_skeleton(segments, mean.row(v), any);
    }
    for (int step = 0; step < final_steps; ++step) projection = neighbour_mean(projection, neighbours);
    return projection;
}

Eigen::VectorXd soft_tissue_share(const WrapSkin& skin)
{
    const Skeleton& skeleton = standard_skeleton();
    Eigen::VectorXd joint_share = Eigen::VectorXd::Constant(skeleton.num_joints(), 0.4);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        std::string name = skeleton.joint_names[j];
        for (const std::string side : {"left_", "right_"})
            if (name.rfind(side, 0) == 0) name = name.substr(side.size());
        const auto found = soft_tissue_share_by_joint().find(name);
        if (found != soft_tissue_share_by_joint().end()) joint_share[j] = found->second;
    }
    Eigen::MatrixXd share = skin.weights * joint_share;
    const auto neighbours = smoothing_neighbours(skin);
    const int steps = smoothing_steps(skin, share_smoothing);
    for (int step = 0; step < steps; ++step) share = neighbour_mean(share, neighbours);
    return share.col(0);
}

Wraps valid_wraps(const WrapSkin& skin, const Eigen::Ref<const Points>& intended_bone, const Eigen::VectorXd& fat_share,
                  double min_scaled_jacobian, const std::string& body_name)
{
    const auto neighbours = vertex_neighbours(skin.triangles, static_cast<int>(skin.vertices.rows()));
    const Points visible = visible_directions(skin);
    Points offsets = intended_bone - skin.vertices;
    Eigen::MatrixXd share = fat_share;
    std::vector<int> adjustments(skin.vertices.rows(), 0);
    Wraps wraps;
    Eigen::Index worst_triangle = -1;
    double worst_jacobian = 0.0;
    for (int step = 0; step <= max_repair_steps; ++step) {
        wraps.bone = skin.vertices + offsets;
        wraps.muscle = skin.vertices;
        for (Eigen::Index v = 0; v < offsets.rows(); ++v) wraps.muscle.row(v) += share(v, 0) * offsets.row(v);
        wraps.min_scaled_jacobian = std::numeric_limits<double>::max();
        std::vector<char> bad(skin.vertices.rows(), 0);
        bool any_bad = false;
        for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t) {
            const PrismVertices fat = stack_prism(skin.vertices, wraps.muscle, skin.triangles, t);
            const PrismVertices muscle = stack_prism(wraps.muscle, wraps.bone, skin.triangles, t);
            const double quality = std::min(prism_min_scaled_jacobian(fat), prism_min_scaled_jacobian(muscle));
            if (quality < wraps.min_scaled_jacobian) {
                wraps.min_scaled_jacobian = quality;
                worst_triangle = t;
                worst_jacobian = std::min(prism_min_jacobian(fat), prism_min_jacobian(muscle));
            }
            if (quality >= min_scaled_jacobian) continue;
            any_bad = true;
            for (int k = 0; k < 3; ++k) bad[skin.triangles(t, k)] = 1;
        }
        if (!any_bad || step == max_repair_steps) break;
        const Points mean_offsets = neighbour_mean(offsets, neighbours);
        const Eigen::MatrixXd mean_share = neighbour_mean(share, neighbours);
        for (Eigen::Index v = 0; v < offsets.rows(); ++v) {
            if (!bad[v]) continue;
            // The more often a vertex comes up, the more its offset turns towards the direction that is always valid.
            const double turn = std::min(1.0, 0.05 * ++adjustments[v]);
            const double length = std::min(offsets.row(v).norm(), mean_offsets.row(v).norm() * 1.5) * repair_shortening;
            const Eigen::RowVector3d direction =
                (1.0 - turn) * mean_offsets.row(v).normalized() + turn * visible.row(v);
            offsets.row(v) = direction.normalized() * std::max(length, min_tissue_thickness);
            share(v, 0) = 0.5 * (share(v, 0) + mean_share(v, 0));
        }
    }
    require(worst_jacobian > 0.0,
            "body {}: no valid layers found: the prisms of skin triangle {} near ({:.3f}, {:.3f}, {:.3f}) have a "
            "Jacobian of "
            "{:.3g} m^3 (smallest scaled Jacobian {:.3g})",
            body_name, worst_triangle, skin.vertices(skin.triangles(worst_triangle, 0), 0),
            skin.vertices(skin.triangles(worst_triangle, 0), 1), skin.vertices(skin.triangles(worst_triangle, 0), 2),
            worst_jacobian, wraps.min_scaled_jacobian);
    wraps.adjusted_vertices =
        static_cast<int>(std::count_if(adjustments.begin(), adjustments.end(), [](int count) { return count > 0; }));
    return wraps;
}

}  // namespace ndg
