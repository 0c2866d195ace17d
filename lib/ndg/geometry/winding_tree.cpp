// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/winding_tree.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ndg {

namespace {

constexpr double far_radii = 2.5;  ///< beta of Barill et al.
constexpr int leaf_size = 8;

}  // namespace

double half_solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double length_a,
                        double length_b, double length_c)
{
    const double determinant = a.dot(b.cross(c));
    const double denominator =
        length_a * length_b * length_c + a.dot(b) * length_c + b.dot(c) * length_a + c.dot(a) * length_b;
    return std::atan2(determinant, denominator);
}

WindingTree::WindingTree(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    require(triangles.rows() > 0, "A winding number was asked of a mesh without triangles");
    std::vector<int> order(triangles.rows());
    std::iota(order.begin(), order.end(), 0);
    corners_.resize(order.size());
    for (std::size_t t = 0; t < order.size(); ++t)
        for (int k = 0; k < 3; ++k) corners_[t].col(k) = vertices.row(triangles(t, k)).transpose();
    build(order, 0, int(order.size()));
    std::vector<Eigen::Matrix3d> sorted;
    for (const int t : order) sorted.push_back(corners_[t]);
    corners_ = std::move(sorted);
}

int WindingTree::build(std::vector<int>& order, int begin, int end)
{
    Node node;
    node.begin = begin;
    node.end = end;
    double area_sum = 0.0;
    Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
    const auto area_normal = [&](int i) -> Eigen::Vector3d {
        const Eigen::Matrix3d& c = corners_[order[i]];
        return 0.5 * (c.col(1) - c.col(0)).cross(c.col(2) - c.col(0));
    };
    const auto centroid = [&](int i) -> Eigen::Vector3d { return corners_[order[i]].rowwise().mean(); };
    for (int i = begin; i < end; ++i) {
        const double area = area_normal(i).norm();
        area_sum += area;
        node.centre += area * centroid(i);
        low = low.cwiseMin(centroid(i));
        high = high.cwiseMax(centroid(i));
    }
    node.centre = area_sum > 0.0 ? Eigen::Vector3d(node.centre / area_sum) : Eigen::Vector3d(0.5 * (low + high));
    for (int i = begin; i < end; ++i) {
        node.dipole += area_normal(i);
        node.moment += (centroid(i) - node.centre) * area_normal(i).transpose();
        node.radius = std::max(node.radius, (corners_[order[i]].colwise() - node.centre).colwise().norm().maxCoeff());
    }
    const int index = int(nodes_.size());
    nodes_.push_back(node);
    if (end - begin <= leaf_size) return index;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    // Ties by index, so that the tree is the same everywhere.
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, [&](int a, int b) {
        const double at_a = corners_[a].row(axis).sum(), at_b = corners_[b].row(axis).sum();
        return at_a != at_b ? at_a < at_b : a < b;
    });
    build(order, begin, middle);
    const int right = build(order, middle, end);
    nodes_[index].right = right;
    return index;
}

double WindingTree::winding_number(const Eigen::Vector3d& point) const
{
    double half_angles = 0.0, expansions = 0.0;  // 4 pi w = 2 half_angles + expansions
    std::vector<int> stack = {0};
    while (!stack.empty()) {
        const int index = stack.back();
        const Node& node = nodes_[index];
        stack.pop_back();
        const Eigen::Vector3d r = node.centre - point;
        const double squared = r.squaredNorm();
        if (squared > far_radii * far_radii * node.radius * node.radius) {
            // Of r/|r|^3 against the dipole, and of its derivative I/|r|^3 - 3 r r^T/|r|^5 against the moment.
            const double cubed = squared * std::sqrt(squared);
            expansions += (r.dot(node.dipole) + node.moment.trace() - 3.0 * r.dot(node.moment * r) / squared) / cubed;
        } else if (node.right < 0) {
            for (int t = node.begin; t < node.end; ++t) {
                const Eigen::Matrix3d c = corners_[t].colwise() - point;
                half_angles +=
                    half_solid_angle(c.col(0), c.col(1), c.col(2), c.col(0).norm(), c.col(1).norm(), c.col(2).norm());
            }
        } else {
            stack.push_back(node.right);
            stack.push_back(index + 1);
        }
    }
    return (2.0 * half_angles + expansions) / (4.0 * M_PI);
}

}  // namespace ndg
