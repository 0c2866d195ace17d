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
    std::vector<std::vector<Part>> about(count);
    std::vector<std::vector<int>> cells(nodes.size());
    for (std::size_t v = 0; v < count; ++v) cells[node_of_[v]].push_back(int(v));
    for (const int v : nodes) {
        for (const auto& [distance, w] : along.within(v, reach)) {
            if (node_at[w] >= 0) {
                reached_.push_back(node_at[w]);
                distances_.push_back(float(distance));
            }
            if (distance >= blended) continue;
            about[w].push_back({node_at[v], float(bell(distance / blended))});
            touched_.push_back(node_of_[w]);
        }
        const auto first = touched_.begin() + touched_begins_.back();
        std::sort(first, touched_.end());
        touched_.erase(std::unique(first, touched_.end()), touched_.end());
        reached_begins_.push_back(int(reached_.size()));
        touched_begins_.push_back(int(touched_.size()));
    }
    constexpr std::size_t filled = 4;  // to multiples of it, so that loops over parts have few lengths
    for (const std::vector<int>& cell : cells) {
        for (const int v : cell) {
            float sum = 0.0F;
            for (const Part& part : about[v]) sum += part.weight;
            for (const Part& part : about[v]) parts_.push_back({part.node, part.weight / sum});
            while (parts_.size() % filled != 0) parts_.push_back({parts_.back().node, 0.0F});
            part_begins_.push_back(int(parts_.size()));
        }
        cells_.insert(cells_.end(), cell.begin(), cell.end());
        cell_begins_.push_back(int(cells_.size()));
    }
    node_weights_ = Eigen::MatrixXf::Zero(Eigen::Index(nodes.size()), num_widths());
    for (int w = 0; w < num_widths(); ++w)
        for (std::size_t node = 0; node < nodes.size(); ++node)
            for (int k = reached_begins_[node]; k < reached_begins_[node + 1]; ++k)
                node_weights_(Eigen::Index(node), w) += bell(distances_[k] / widths_[w]);
}

void SurfaceSpread::Pushes::reset(const SurfaceSpread& spread)
{
    const std::size_t num_nodes = spread.cell_begins_.size() - 1;
    spread_ = &spread;
    if (pushed_.empty() && lengths_.size() == num_nodes) return;
    pushed_.clear();
    lengths_.assign(num_nodes, 0.0F);
    longest_.setZero(4, Eigen::Index(num_nodes));
    means_.setZero(4, Eigen::Index(num_nodes));
    near_.assign(num_nodes + 1, 0);
    touched_.assign(num_nodes + 1, 0);
    bells_.assign(num_nodes, 0.0F);
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
    float* const bells = pushes.bells_.data();
    int num_near = 0, num_touched = 0;
    // Each list has room for one more than there can be: the next is written before it is known to be new.
    const auto add = [](int node, std::vector<int>& list, std::vector<char>& is_in, int& count) {
        list[count] = node;
        count += int(is_in[node] == 0);
        is_in[node] = 1;
    };
    for (const int node : pushes.pushed_) {
        const Eigen::Vector4f push = pushes.longest_.col(node);
        const float* const distances = distances_.data() + reached_begins_[node];
        const int* const reached = reached_.data() + reached_begins_[node];
        const float* const end = distances_.data() + reached_begins_[node + 1];
        const int count = int(std::lower_bound(distances, end, width) - distances);
        for (int k = 0; k < count; ++k) bells[k] = bell(distances[k] / width);
        for (int k = 0; k < count; ++k) {
            add(reached[k], pushes.near_, pushes.is_near_, num_near);
            means.col(reached[k]) += bells[k] * push;
        }
    }
    for (int i = 0; i < num_near; ++i) {
        const int node = pushes.near_[i];
        means.col(node) /= node_weights_(node, width_idx);
        for (int k = touched_begins_[node]; k < touched_begins_[node + 1]; ++k)
            add(touched_[k], pushes.touched_, pushes.is_touched_, num_touched);
    }
#pragma omp parallel for schedule(static) if (num_touched > 256)
    for (int i = 0; i < num_touched; ++i) {
        const int node = pushes.touched_[i];
        for (int c = cell_begins_[node]; c < cell_begins_[node + 1]; ++c) {
            Eigen::Vector4f shift = Eigen::Vector4f::Zero();
            for (int k = part_begins_[c]; k < part_begins_[c + 1]; ++k)
                shift += parts_[k].weight * means.col(parts_[k].node);
            surface.col(cells_[c]) += shift;
        }
    }
    std::vector<int>& moved = pushes.moved_;
    moved.clear();
    for (int i = 0; i < num_touched; ++i) {
        const int node = pushes.touched_[i];
        moved.insert(moved.end(), cells_.begin() + cell_begins_[node], cells_.begin() + cell_begins_[node + 1]);
        pushes.is_touched_[node] = 0;
    }
    for (int i = 0; i < num_near; ++i) {
        pushes.is_near_[pushes.near_[i]] = 0;
        means.col(pushes.near_[i]).setZero();
    }
    for (const int node : pushes.pushed_) pushes.lengths_[node] = 0.0F;
    pushes.pushed_.clear();
    return moved;
}

}  // namespace ndg
