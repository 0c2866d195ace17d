// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/surface_spread.h"

#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace ndg {

namespace {

/// 1 at 0, falling smoothly to 0 at 1.
double bell(double t)
{
    const double rest = std::max(1.0 - t * t, 0.0);
    return rest * rest;
}

/// Vertices within a distance of one along the edges of a surface (Dijkstra 1959).
class AlongSurface {
public:
    using Entry = std::pair<double, int>;  ///< distance, vertex

    AlongSurface(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
        : vertices_(vertices),
          beside_(vertex_neighbours(triangles, int(vertices.rows()))),
          distances_(std::size_t(vertices.rows()), std::numeric_limits<double>::infinity())
    {
    }

    /// The nearest first.
    const std::vector<Entry>& within(int start, double reach)
    {
        for (const auto& [distance, v] : found_) distances_[v] = std::numeric_limits<double>::infinity();
        found_.clear();
        std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
        distances_[start] = 0.0;
        queue.push({0.0, start});
        while (!queue.empty()) {
            const auto [distance, v] = queue.top();
            queue.pop();
            if (distance > distances_[v]) continue;
            found_.emplace_back(distance, v);
            for (const int other : beside_[v]) {
                const double there = distance + (vertices_.row(v) - vertices_.row(other)).norm();
                if (there >= distances_[other] || there > reach) continue;
                distances_[other] = there;
                queue.push({there, other});
            }
        }
        return found_;
    }

private:
    const Points vertices_;
    std::vector<std::vector<int>> beside_;
    std::vector<double> distances_;  ///< infinite but for what was found last
    std::vector<Entry> found_;
};

}  // namespace

SurfaceSpread::SurfaceSpread(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                             double reach, double spacing)
{
    const std::size_t count = std::size_t(vertices.rows());
    AlongSurface along(vertices, triangles);
    std::vector<int> nodes, node_at(count, -1);
    std::vector<double> nearest(count, std::numeric_limits<double>::infinity());
    node_of_.assign(count, -1);
    for (std::size_t v = 0; v < count; ++v) {
        if (nearest[v] <= spacing) continue;
        node_at[v] = int(nodes.size());
        for (const auto& [distance, w] : along.within(int(v), spacing)) {
            if (distance >= nearest[w]) continue;
            nearest[w] = distance;
            node_of_[w] = node_at[v];
        }
        nodes.push_back(int(v));
    }
    // Every vertex lies within one spacing of a node.
    const double blended = 1.6 * spacing;
    std::vector<double> sums(count, 0.0);
    for (const int v : nodes) {
        for (const auto& [distance, w] : along.within(v, reach)) {
            if (node_at[w] >= 0) nodes_.entries.push_back({node_at[w], float(distance)});
            if (distance >= blended) continue;
            vertices_.entries.push_back({w, float(bell(distance / blended))});
            sums[w] += bell(distance / blended);
        }
        nodes_.begins.push_back(int(nodes_.entries.size()));
        vertices_.begins.push_back(int(vertices_.entries.size()));
    }
    for (Near& entry : vertices_.entries) entry.value /= float(sums[entry.index]);
}

std::vector<int> SurfaceSpread::spread(const std::vector<int>& sources, double width, Points& vectors) const
{
    const std::size_t count = nodes_.begins.size() - 1;
    std::vector<Eigen::Vector3d> longest(count, Eigen::Vector3d::Zero()), mean(count);
    std::vector<double> lengths(count, 0.0);
    std::vector<char> known(count, 0);
    std::vector<int> pushed, near, moved;
    for (const int v : sources) {
        const int node = node_of_[v];
        const double length = vectors.row(v).squaredNorm();
        if (length > lengths[node]) {
            if (lengths[node] == 0.0) pushed.push_back(node);
            lengths[node] = length;
            longest[node] = vectors.row(v).transpose();
        }
        vectors.row(v).setZero();
    }
    for (const int node : pushed)
        for (int k = nodes_.begins[node]; k < nodes_.begins[node + 1] && nodes_.entries[k].value < width; ++k) {
            const int other = nodes_.entries[k].index;
            if (known[other] == 0) near.push_back(other);
            known[other] = 1;
        }
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < near.size(); ++i) {
        const int node = near[i];
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double weights = 0.0;
        for (int k = nodes_.begins[node]; k < nodes_.begins[node + 1] && nodes_.entries[k].value < width; ++k) {
            const double weight = bell(nodes_.entries[k].value / width);
            sum += weight * longest[nodes_.entries[k].index];
            weights += weight;
        }
        mean[node] = sum / weights;
    }
    for (const int node : near)
        for (int k = vertices_.begins[node]; k < vertices_.begins[node + 1]; ++k) {
            const Near& entry = vertices_.entries[k];
            if (vectors.row(entry.index).isZero(0.0)) moved.push_back(entry.index);
            vectors.row(entry.index) += double(entry.value) * mean[node].transpose();
        }
    return moved;
}

}  // namespace ndg
