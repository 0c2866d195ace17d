// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/skeleton_projection.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr int max_sweeps = 2000;
constexpr double sweep_tolerance = 1e-5;  // m

}  // namespace

SkeletonTree::SkeletonTree(const Skeleton& skeleton, const Eigen::Ref<const Points>& joint_positions,
                           const std::vector<bool>& flesh_joints)
    : parents_(skeleton.parents), positions_(joint_positions)
{
    const int k = skeleton.num_joints();
    require(joint_positions.rows() == k, "{} joint positions were given for {} joints", joint_positions.rows(), k);
    require(flesh_joints.empty() || int(flesh_joints.size()) == k, "{} joints move flesh or not, of {}",
            flesh_joints.size(), k);
    for (int j = 1; j < k; ++j)
        if (flesh_joints.empty() || flesh_joints[parents_[j]]) candidates_.push_back(j);
    require_input(!candidates_.empty(), "a skeleton of {} joints has no bone in the flesh to project to", k);
    lengths_.assign(k, 0.0);
    bones_at_.resize(k);
    distances_ = RowMatrix::Zero(k, k);
    for (int j = 1; j < k; ++j) {
        const int parent = parents_[j];
        lengths_[j] = (positions_.row(j) - positions_.row(parent)).norm();
        bones_at_[j].push_back(j);
        bones_at_[parent].push_back(j);
        for (int other = 0; other < j; ++other)
            distances_(j, other) = distances_(other, j) = distances_(parent, other) + lengths_[j];
    }
}

Eigen::Vector3d SkeletonTree::position(const SkeletonPoint& point) const
{
    const Eigen::Vector3d begin = positions_.row(parents_[point.joint]), end = positions_.row(point.joint);
    const double length = lengths_[point.joint];
    return length > 0 ? Eigen::Vector3d(begin + (end - begin) * (point.along / length)) : begin;
}

SkeletonPoint SkeletonTree::nearest(const Eigen::Vector3d& position) const
{
    SkeletonPoint best;
    double least = std::numeric_limits<double>::max();
    for (const int j : candidates_) {
        const Eigen::Vector3d begin = positions_.row(parents_[j]), end = positions_.row(j);
        const double length = lengths_[j];
        const double along = length > 0 ? std::clamp((position - begin).dot(end - begin) / length, 0.0, length) : 0.0;
        const double distance = (this->position({j, along}) - position).squaredNorm();
        if (distance < least) {
            least = distance;
            best = {j, along};
        }
    }
    return best;
}

double SkeletonTree::coordinate(int joint, const SkeletonPoint& point) const
{
    if (point.joint == joint) return point.along;
    const double length = lengths_[point.joint], back = point.along, on = length - point.along;
    const auto to = [&](int node) {
        return std::min(back + distances_(parents_[point.joint], node), on + distances_(point.joint, node));
    };
    const double from_begin = to(parents_[joint]), from_end = to(joint);
    return from_begin < from_end ? -from_begin : lengths_[joint] + from_end;
}

double SkeletonTree::distance(const SkeletonPoint& a, const SkeletonPoint& b) const
{
    return std::abs(coordinate(a.joint, b) - a.along);
}

SkeletonPoint SkeletonTree::mean(const std::vector<SkeletonPoint>& points, const std::vector<double>& weights,
                                 const SkeletonPoint& start) const
{
    // Along one bone the sum is a parabola. It is convex along every way through the tree, so the way down leads to its
    // least place: over a joint into the one bone, if any, on which the sum goes on falling.
    const auto lowest_on = [&](int joint) {
        double sum = 0, total = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            sum += weights[i] * coordinate(joint, points[i]);
            total += weights[i];
        }
        return sum / total;
    };
    int joint = start.joint;
    double along = lowest_on(joint);
    for (std::size_t step = 0; step <= parents_.size(); ++step) {
        if (along >= 0 && along <= lengths_[joint]) return {joint, along};
        const bool at_end = along > lengths_[joint];
        const int node = at_end ? joint : parents_[joint];
        const SkeletonPoint at_node{joint, at_end ? lengths_[joint] : 0.0};
        bool falls = false;
        for (const int bone : bones_at_[node]) {
            if (bone == joint) continue;
            const double lowest = lowest_on(bone);
            const bool begins_here = parents_[bone] == node;
            if (begins_here ? lowest <= 0 : lowest >= lengths_[bone]) continue;
            joint = bone;
            along = lowest;
            falls = true;
            break;
        }
        if (!falls) return at_node;
    }
    throw Error("the mean of places on a skeleton was not found");
}

std::vector<SkeletonPoint> project_to_skeleton(const SkeletonTree& tree, const Eigen::Ref<const Points>& vertices,
                                               const Eigen::Ref<const Triangles>& triangles,
                                               const ProjectionOptions& options)
{
    const auto count = std::size_t(vertices.rows());
    std::vector<SkeletonPoint> nearest(count);
    for (std::size_t v = 0; v < count; ++v) nearest[v] = tree.nearest(vertices.row(Eigen::Index(v)).transpose());
    if (options.smoothing_length <= 0) return nearest;

    const std::vector<std::vector<int>> neighbours = vertex_neighbours(triangles, int(count));
    std::vector<std::vector<double>> weights(count);  // of the neighbours, then of the vertex's own nearest place
    for (std::size_t v = 0; v < count; ++v) {
        double mean_length = 0;
        for (const int other : neighbours[v])
            mean_length += (vertices.row(other) - vertices.row(Eigen::Index(v))).norm() / double(neighbours[v].size());
        const double share = mean_length / options.smoothing_length;
        weights[v].assign(neighbours[v].size(), 1.0);
        weights[v].push_back(std::max(double(neighbours[v].size()), 1.0) * share * share);
    }
    std::vector<SkeletonPoint> places = nearest, around;
    for (int sweep = 0; sweep < max_sweeps; ++sweep) {
        double farthest = 0;
        for (std::size_t v = 0; v < count; ++v) {
            if (neighbours[v].empty()) continue;
            around.clear();
            for (const int other : neighbours[v]) around.push_back(places[std::size_t(other)]);
            around.push_back(nearest[v]);
            const SkeletonPoint moved = tree.mean(around, weights[v], places[v]);
            farthest = std::max(farthest, tree.distance(moved, places[v]));
            places[v] = moved;
        }
        if (farthest <= sweep_tolerance) break;
    }
    return places;
}

}  // namespace ndg
