// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/edge_length_field.h"

#include "ndg/body/skeleton.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <string>
#include <utility>

namespace ndg {
namespace {

constexpr int num_bins = 10;  ///< along each section of a limb

/// One section of a limb: from a joint to the next, with the joints whose weights belong to it.
struct LimbSection {
    Eigen::RowVector3d begin, end;
    std::vector<int> joints;
    double roundness = 1.0;  ///< the skin's own radius of curvature is this share of its distance from the axis
};

std::vector<LimbSection> limb_sections(const Eigen::Ref<const Points>& joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<LimbSection> sections;
    for (const std::string side : {"left_", "right_"}) {
        const auto add = [&](const std::string& from, const std::string& to, std::vector<int> joints,
                             double roundness = 1.0) {
            sections.push_back({joint_positions.row(skeleton.joint(side + from)),
                                joint_positions.row(skeleton.joint(side + to)), std::move(joints), roundness});
        };
        std::vector<int> forearm = {skeleton.joint(side + "forearm"), skeleton.joint(side + "forearm_twist")};
        const int hand = skeleton.joint(side + "hand");
        for (int j = 0; j < skeleton.num_joints(); ++j) {
            int ancestor = j;
            while (ancestor >= 0 && ancestor != hand) ancestor = skeleton.parents[ancestor];
            if (ancestor == hand) forearm.push_back(j);
        }
        add("upper_arm", "forearm", {skeleton.joint(side + "upper_arm")});
        add("forearm", "hand", forearm);
        add("thigh", "shin", {skeleton.joint(side + "thigh")});
        add("shin", "foot", {skeleton.joint(side + "shin")});
        add("foot", "toes", {skeleton.joint(side + "foot"), skeleton.joint(side + "toes")}, 0.8);  // the heel
    }
    return sections;
}

/// Mean distances from the axis in bins along it; empty bins take their neighbour's.
struct RadiusProfile {
    std::array<double, num_bins> radius{};

    double at(double share) const
    {
        const double place = std::clamp(share * num_bins - 0.5, 0.0, num_bins - 1.0);
        const auto low = static_cast<std::size_t>(std::min(place, num_bins - 2.0));
        const double t = place - static_cast<double>(low);
        return (1.0 - t) * radius[low] + t * radius[low + 1];
    }
};

/// Share of the way along the axis, not limited to it, and distance from the axis.
std::pair<double, double> axis_place(const LimbSection& section, const Eigen::RowVector3d& point)
{
    const Eigen::RowVector3d along = section.end - section.begin;
    const double share = (point - section.begin).dot(along) / std::max(along.squaredNorm(), 1e-12);
    return {share, (point - section.begin - std::clamp(share, 0.0, 1.0) * along).norm()};
}

}  // namespace

Eigen::VectorXd limb_radius(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const RowMatrix>& weights,
                            const Eigen::Ref<const Points>& joint_positions, double trunk_radius)
{
    Eigen::VectorXd radius = Eigen::VectorXd::Zero(vertices.rows()), total = radius;
    for (const LimbSection& section : limb_sections(joint_positions)) {
        Eigen::VectorXd share = Eigen::VectorXd::Zero(vertices.rows());
        for (const int joint : section.joints) share += weights.col(joint);
        RadiusProfile profile;
        std::array<double, num_bins> weight{};
        for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
            const auto [place, distance] = axis_place(section, vertices.row(v));
            if (share[v] < 0.5 || place < 0.0 || place > 1.0) continue;
            const auto bin = static_cast<std::size_t>(std::min(num_bins - 1.0, place * num_bins));
            profile.radius[bin] += share[v] * distance;
            weight[bin] += share[v];
        }
        double last = trunk_radius;
        for (std::size_t bin = 0; bin < num_bins; ++bin) {
            if (weight[bin] > 0.0) last = profile.radius[bin] / weight[bin];
            profile.radius[bin] = last;
        }
        for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
            if (share[v] <= 0.0) continue;
            radius[v] += share[v] * section.roundness * profile.at(axis_place(section, vertices.row(v)).first);
            total[v] += share[v];
        }
    }
    for (Eigen::Index v = 0; v < radius.size(); ++v) radius[v] += std::max(0.0, 1.0 - total[v]) * trunk_radius;
    return radius;
}

EdgeDistance distance_along_edges(const Eigen::Ref<const Points>& vertices,
                                  const Eigen::Ref<const Triangles>& triangles, const std::vector<int>& starts)
{
    const auto neighbours = vertex_neighbours(triangles, static_cast<int>(vertices.rows()));
    EdgeDistance result{Eigen::VectorXd::Constant(vertices.rows(), std::numeric_limits<double>::infinity()),
                        std::vector<int>(static_cast<std::size_t>(vertices.rows()), -1)};
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;  // Dijkstra 1959
    for (const int start : starts) {
        result.distance[start] = 0.0;
        result.nearest[start] = start;
        queue.push({0.0, start});
    }
    while (!queue.empty()) {
        const auto [distance, v] = queue.top();
        queue.pop();
        if (distance > result.distance[v]) continue;
        for (const int other : neighbours[v]) {
            const double candidate = distance + (vertices.row(v) - vertices.row(other)).norm();
            if (candidate >= result.distance[other]) continue;
            result.distance[other] = candidate;
            result.nearest[other] = result.nearest[v];
            queue.push({candidate, other});
        }
    }
    return result;
}

Eigen::VectorXd mean_edge_length(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(vertices.rows()), count = sum;
    for (const MeshEdge& edge : mesh_edges(triangles, static_cast<int>(vertices.rows())))
        for (const int v : {edge.v0, edge.v1}) {
            sum[v] += (vertices.row(edge.v0) - vertices.row(edge.v1)).norm();
            count[v] += 1.0;
        }
    return sum.array() / count.array().max(1.0);
}

}  // namespace ndg
