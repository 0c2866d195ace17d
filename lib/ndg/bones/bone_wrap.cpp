// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_wrap.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace ndg {

namespace {

/// Triangles of all bones of one segment and the box around them.
struct SegmentSurface {
    std::vector<Eigen::RowVector3i> triangles;
    Eigen::AlignedBox3d box;
    std::unique_ptr<TriangleTree> tree;
};

std::vector<SegmentSurface> segment_surfaces(const BoneList& list, const Template& body_template,
                                             const Eigen::Ref<const Points>& anatomy_rest)
{
    std::vector<SegmentSurface> surfaces(list.num_segments);
    for (const BoneList::Bone& bone : list.bones) {
        SegmentSurface& surface = surfaces[bone.segment];
        for (int t = bone.triangle_begin; t < bone.triangle_end; ++t)
            surface.triangles.push_back(body_template.anatomy_triangles.row(t));
        for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) surface.box.extend(anatomy_rest.row(v).transpose());
    }
    for (SegmentSurface& surface : surfaces) {
        Triangles triangles(Eigen::Index(surface.triangles.size()), 3);
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            triangles.row(Eigen::Index(t)) = surface.triangles[t];
        surface.tree = std::make_unique<TriangleTree>(anatomy_rest, triangles);
    }
    return surfaces;
}

}  // namespace

NearBones near_bones(const BoneList& list, const Template& body_template, const Eigen::Ref<const Points>& anatomy_rest,
                     const Eigen::Ref<const Points>& points, double width)
{
    require(list.num_segments > 0, "no bones to follow");
    const std::vector<SegmentSurface> surfaces = segment_surfaces(list, body_template, anatomy_rest);
    std::vector<std::vector<std::pair<int, double>>> influences(points.rows());
    NearBones result;
    result.distances.resize(points.rows());
#pragma omp parallel for schedule(dynamic, 64)
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Eigen::Vector3d point = points.row(i).transpose();
        std::vector<std::pair<double, int>> boxes;
        for (int s = 0; s < list.num_segments; ++s) boxes.emplace_back(surfaces[s].box.exteriorDistance(point), s);
        std::sort(boxes.begin(), boxes.end());
        double nearest = std::numeric_limits<double>::infinity();
        std::vector<std::pair<int, double>>& found = influences[i];
        for (const auto& [box_distance, s] : boxes) {
            if (box_distance > width + 2.0 * nearest) break;
            const double distance = surfaces[s].tree->closest(point).distance;
            nearest = std::min(nearest, distance);
            found.emplace_back(s, distance);
        }
        double sum = 0.0;
        for (auto& [s, value] : found) {
            const double t = std::min((value - nearest) / (width + nearest), 1.0);
            value = (1.0 - t * t) * (1.0 - t * t);
            sum += value;
        }
        for (auto& [s, value] : found) value /= sum;
        result.distances[i] = nearest;
    }
    BoneWeights& weights = result.weights;
    weights.begins.push_back(0);
    for (const auto& found : influences) {
        for (const auto& [s, value] : found) {
            if (value <= 0.0) continue;
            weights.segments.push_back(s);
            weights.weights.push_back(value);
        }
        weights.begins.push_back(int(weights.segments.size()));
    }
    return result;
}

BoneWeights smoothed_weights(const BoneWeights& weights, const Eigen::Ref<const Points>& vertices,
                             const Eigen::Ref<const Triangles>& triangles, double spread)
{
    const auto neighbours = vertex_neighbours(triangles, int(vertices.rows()));
    double edge = 0.0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        edge += (vertices.row(triangles(t, 0)) - vertices.row(triangles(t, 1))).norm() / double(triangles.rows());
    // A step takes half of a vertex's weights to its neighbours: a variance of a quarter of an edge squared along each
    // direction of the surface.
    const int steps = int(std::lround(4.0 * spread * spread / (edge * edge)));
    std::vector<std::map<int, double>> current(weights.size());
    for (Eigen::Index i = 0; i < weights.size(); ++i)
        for (int k = weights.begins[i]; k < weights.begins[i + 1]; ++k)
            current[i][weights.segments[k]] = weights.weights[k];
    for (int step = 0; step < steps; ++step) {
        std::vector<std::map<int, double>> next(current.size());
        for (std::size_t i = 0; i < current.size(); ++i) {
            const double kept = neighbours[i].empty() ? 1.0 : 0.5;
            for (const auto& [s, w] : current[i]) next[i][s] += kept * w;
            for (const int j : neighbours[i])
                for (const auto& [s, w] : current[j]) next[i][s] += 0.5 * w / double(neighbours[i].size());
        }
        current = std::move(next);
    }
    constexpr double least = 0.02;
    BoneWeights result;
    result.begins.push_back(0);
    for (const auto& row : current) {
        double sum = 0.0;
        for (const auto& [s, w] : row) sum += w >= least ? w : 0.0;
        for (const auto& [s, w] : row) {
            if (w < least) continue;
            result.segments.push_back(s);
            result.weights.push_back(w / sum);
        }
        result.begins.push_back(int(result.segments.size()));
    }
    return result;
}

Points dual_quaternion_blending(const Eigen::Ref<const Points>& rest, const BoneWeights& weights,
                                const std::vector<Eigen::Isometry3d>& motions)
{
    require(weights.size() == rest.rows(), "{} points were given weights of {}", rest.rows(), weights.size());
    using Dual = Eigen::Matrix<double, 8, 1>;  // real part x, y, z, w; dual part
    std::vector<Dual> duals;
    for (const Eigen::Isometry3d& motion : motions) {
        const Eigen::Quaterniond real = Eigen::Quaterniond(motion.linear()).normalized();
        const Eigen::Vector3d t = motion.translation();
        Dual dual;
        dual.head<4>() = real.coeffs();
        dual.tail<4>() = 0.5 * (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * real).coeffs();
        duals.push_back(dual);
    }
    Points posed(rest.rows(), 3);
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
        const int begin = weights.begins[i], end = weights.begins[i + 1];
        const auto heaviest = std::max_element(weights.weights.begin() + begin, weights.weights.begin() + end);
        const auto reference = duals[weights.segments[heaviest - weights.weights.begin()]].head<4>();
        Dual sum = Dual::Zero();
        for (int k = begin; k < end; ++k) {
            const Dual& dual = duals[weights.segments[k]];
            // q and -q are the same motion.
            sum += (dual.head<4>().dot(reference) < 0.0 ? -weights.weights[k] : weights.weights[k]) * dual;
        }
        sum /= sum.head<4>().norm();
        const Eigen::Vector3d real = sum.head<3>(), dual = sum.segment<3>(4), x = rest.row(i).transpose();
        const Eigen::Vector3d turned = x + 2.0 * real.cross(real.cross(x) + sum[3] * x);
        posed.row(i) = (turned + 2.0 * (sum[3] * dual - sum[7] * real + real.cross(dual))).transpose();
    }
    return posed;
}

}  // namespace ndg
