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
template <typename Real>
Real bell(Real t)
{
    const Real rest = std::max(Real(1) - t * t, Real(0));
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
                             const std::vector<double>& widths, double spacing)
    : widths_(widths.begin(), widths.end())
{
    const std::size_t count = std::size_t(vertices.rows());
    const double reach = *std::max_element(widths.begin(), widths.end());
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
    std::vector<std::vector<Near>> about(count);
    std::vector<std::vector<int>> cells(nodes.size());
    for (std::size_t v = 0; v < count; ++v) cells[node_of_[v]].push_back(int(v));
    touched_begins_.push_back(0);
    for (const int v : nodes) {
        for (const auto& [distance, w] : along.within(v, reach)) {
            if (node_at[w] >= 0) nodes_.entries.push_back({node_at[w], float(distance)});
            if (distance >= blended) continue;
            about[w].push_back({node_at[v], float(bell(distance / blended))});
            touched_.push_back(node_of_[w]);
        }
        const auto first = touched_.begin() + touched_begins_.back();
        std::sort(first, touched_.end());
        touched_.erase(std::unique(first, touched_.end()), touched_.end());
        nodes_.begins.push_back(int(nodes_.entries.size()));
        touched_begins_.push_back(int(touched_.size()));
    }
    cell_begins_.push_back(0);
    for (const std::vector<int>& cell : cells) {
        cells_.insert(cells_.end(), cell.begin(), cell.end());
        cell_begins_.push_back(int(cells_.size()));
    }
    for (std::vector<Near>& of_vertex : about) {
        float sum = 0.0F;
        for (const Near& entry : of_vertex) sum += entry.value;
        for (const Near& entry : of_vertex) vertices_.entries.push_back({entry.index, entry.value / sum});
        vertices_.begins.push_back(int(vertices_.entries.size()));
    }
    node_weights_ = Eigen::MatrixXf::Zero(Eigen::Index(nodes.size()), num_widths());
    for (int w = 0; w < num_widths(); ++w)
        for (std::size_t node = 0; node < nodes.size(); ++node)
            for (int k = nodes_.begins[node]; k < nodes_.begins[node + 1]; ++k)
                node_weights_(Eigen::Index(node), w) += bell(nodes_.entries[k].value / widths_[w]);
}

void SurfaceSpread::Pushes::reset(const SurfaceSpread& spread)
{
    const std::size_t num_nodes = spread.nodes_.begins.size() - 1;
    spread_ = &spread;
    if (pushed_.empty() && lengths_.size() == num_nodes) return;
    pushed_.clear();
    lengths_.assign(num_nodes, 0.0F);
    longest_.setZero(4, Eigen::Index(num_nodes));
    means_.setZero(4, Eigen::Index(num_nodes));
    is_near_.assign(num_nodes, 0);
    is_touched_.assign(num_nodes, 0);
}

void SurfaceSpread::Pushes::add(int vertex, const Eigen::Vector3f& push)
{
    const int node = spread_->node_of_[vertex];
    const float length = push.squaredNorm();
    if (length <= lengths_[node]) return;
    if (lengths_[node] == 0.0F) pushed_.push_back(node);
    lengths_[node] = length;
    longest_.col(node).head<3>() = push;
}

const std::vector<int>& SurfaceSpread::spread(Pushes& pushes, int width_idx, PointColumnsF& surface) const
{
    const float width = widths_[width_idx];
    PointColumnsF& means = pushes.means_;
    pushes.near_.clear();
    pushes.touched_.clear();
    for (const int node : pushes.pushed_) {
        const Eigen::Vector4f push = pushes.longest_.col(node);
        for (int k = nodes_.begins[node]; k < nodes_.begins[node + 1] && nodes_.entries[k].value < width; ++k) {
            const int other = nodes_.entries[k].index;
            if (pushes.is_near_[other] == 0) pushes.near_.push_back(other);
            pushes.is_near_[other] = 1;
            means.col(other) += bell(nodes_.entries[k].value / width) * push;
        }
    }
    for (const int node : pushes.near_) {
        means.col(node) /= node_weights_(node, width_idx);
        for (int k = touched_begins_[node]; k < touched_begins_[node + 1]; ++k) {
            if (pushes.is_touched_[touched_[k]] == 0) pushes.touched_.push_back(touched_[k]);
            pushes.is_touched_[touched_[k]] = 1;
        }
    }
    std::vector<int>& moved = pushes.moved_;
    moved.clear();
    for (const int node : pushes.touched_) {
        moved.insert(moved.end(), cells_.begin() + cell_begins_[node], cells_.begin() + cell_begins_[node + 1]);
        pushes.is_touched_[node] = 0;
    }
#pragma omp parallel for schedule(static) if (moved.size() > 512)
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const int v = moved[i];
        Eigen::Vector4f shift = Eigen::Vector4f::Zero();
        for (int k = vertices_.begins[v]; k < vertices_.begins[v + 1]; ++k)
            shift += vertices_.entries[k].value * means.col(vertices_.entries[k].index);
        surface.col(v) += shift;
    }
    for (const int node : pushes.near_) {
        pushes.is_near_[node] = 0;
        means.col(node).setZero();
    }
    for (const int node : pushes.pushed_) pushes.lengths_[node] = 0.0F;
    pushes.pushed_.clear();
    return moved;
}

}  // namespace ndg
