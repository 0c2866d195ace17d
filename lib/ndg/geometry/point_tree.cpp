// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/point_tree.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace ndg {
namespace {

constexpr int leaf_size = 8;
/// Depth of a median-split tree over 2^31 points, with room to spare.
constexpr std::size_t max_stack = 64;

double box_squared_distance(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& query)
{
    return (low - query).cwiseMax(query - high).cwiseMax(0.0).squaredNorm();
}

}  // namespace

PointTree::PointTree(const Eigen::Ref<const Points>& points)
    : points_(points), order_(static_cast<std::size_t>(points.rows()))
{
    require(points.rows() > 0, "a tree over points needs a point");
    std::iota(order_.begin(), order_.end(), 0);
    build(0, static_cast<int>(points.rows()));
    Points sorted(points.rows(), 3);
    for (std::size_t i = 0; i < order_.size(); ++i) sorted.row(static_cast<Eigen::Index>(i)) = points_.row(order_[i]);
    points_ = std::move(sorted);
}

int PointTree::build(int begin, int end)
{
    const auto node_idx = nodes_.size();
    nodes_.emplace_back();
    Eigen::AlignedBox3d box;
    for (int i = begin; i < end; ++i) {
        box.extend(Eigen::Vector3d(points_.row(order_[i]).transpose()));
    }
    nodes_[node_idx].low = box.min();
    nodes_[node_idx].high = box.max();
    nodes_[node_idx].begin = begin;
    nodes_[node_idx].end = end;
    if (end - begin <= leaf_size) return static_cast<int>(node_idx);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
        return points_(a, axis) != points_(b, axis) ? points_(a, axis) < points_(b, axis) : a < b;
    });
    build(begin, middle);
    nodes_[node_idx].right = build(middle, end);
    return static_cast<int>(node_idx);
}

void PointTree::search(const Eigen::Vector3d& query, std::vector<Neighbour>& heap, std::size_t count) const
{
    struct Entry {
        int node;
        double squared_distance;
    };
    std::array<Entry, max_stack> stack;
    std::size_t height = 0;
    stack[height++] = {0, 0.0};
    while (height > 0) {
        const Entry entry = stack[--height];
        if (heap.size() == count && entry.squared_distance > heap.front().squared_distance) continue;
        const Node& node = nodes_[entry.node];
        if (node.right < 0) {
            for (int i = node.begin; i < node.end; ++i) {
                const Neighbour found{order_[i], (points_.row(i).transpose() - query).squaredNorm()};
                if (heap.size() == count) {
                    if (!(found < heap.front())) continue;
                    std::pop_heap(heap.begin(), heap.end());
                    heap.back() = found;
                } else {
                    heap.push_back(found);
                }
                std::push_heap(heap.begin(), heap.end());
            }
            continue;
        }
        const int left_idx = entry.node + 1;
        const Node& left = nodes_[left_idx];
        const Node& right = nodes_[node.right];
        const Entry near_left{left_idx, box_squared_distance(left.low, left.high, query)};
        const Entry near_right{node.right, box_squared_distance(right.low, right.high, query)};
        const bool left_first = near_left.squared_distance <= near_right.squared_distance;
        stack[height++] = left_first ? near_right : near_left;
        stack[height++] = left_first ? near_left : near_right;
    }
}

PointTree::Neighbour PointTree::nearest(const Eigen::Vector3d& query) const
{
    std::vector<Neighbour> heap;
    heap.reserve(1);
    search(query, heap, 1);
    return heap.front();
}

std::vector<PointTree::Neighbour> PointTree::nearest(const Eigen::Vector3d& query, int count) const
{
    std::vector<Neighbour> heap;
    heap.reserve(static_cast<std::size_t>(count) + 1);
    search(query, heap, static_cast<std::size_t>(std::max(count, 1)));
    std::sort(heap.begin(), heap.end());
    return heap;
}

}  // namespace ndg
