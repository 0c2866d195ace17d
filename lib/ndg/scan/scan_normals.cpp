// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan_normals.h"

#include "ndg/scan/scan_orientation.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <vector>

namespace ndg {
namespace {

/// Neighbours along which signs are propagated: few, so that they do not jump between thighs.
constexpr int graph_neighbours = 8;

struct Step {
    double alignment;
    int to, from;
    bool operator<(const Step& other) const
    {
        return std::make_tuple(alignment, -to, -from) < std::make_tuple(other.alignment, -other.to, -other.from);
    }
};

void orient_by_propagation(const Eigen::Ref<const Points>& points, const RowMatrixI& neighbours, double spacing,
                           Points& normals)
{
    const int count = static_cast<int>(points.rows());
    std::vector<std::vector<int>> graph(count);
    const int degree = std::min(graph_neighbours, static_cast<int>(neighbours.cols()));
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < degree; ++k) {
            const int j = neighbours(i, k);
            if (j == i) continue;
            graph[i].push_back(j);
            graph[j].push_back(i);
        }
    }
    std::vector<int> parts(count, -1);
    for (int start = 0; start < count; ++start) {
        if (parts[start] >= 0) continue;
        std::priority_queue<Step> queue;
        const auto leave = [&](int i) {
            parts[i] = start;
            for (const int j : graph[i]) {
                if (parts[j] < 0) queue.push({std::abs(normals.row(i).dot(normals.row(j))), j, i});
            }
        };
        leave(start);
        while (!queue.empty()) {
            const Step step = queue.top();
            queue.pop();
            if (parts[step.to] >= 0) continue;
            if (normals.row(step.to).dot(normals.row(step.from)) < 0) normals.row(step.to) *= -1.0;
            leave(step.to);
        }
    }
    turn_outwards(points, spacing, parts, normals);
}

}  // namespace

Points estimate_normals(const Eigen::Ref<const Points>& points, const PointTree& tree, int num_neighbours,
                        const Eigen::Ref<const Points>& hint)
{
    const Eigen::Index count = points.rows();
    const auto width = std::min<Eigen::Index>(num_neighbours, count);
    RowMatrixI neighbours(count, width);
    Eigen::VectorXd spacings(count);
    Points normals(count, 3);
#pragma omp parallel for schedule(dynamic, 256)
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto found = tree.nearest(points.row(i).transpose(), static_cast<int>(width));
        spacings[i] = width > 1 ? std::sqrt(found[1].squared_distance) : 0.0;
        Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
        for (Eigen::Index k = 0; k < width; ++k) {
            neighbours(i, k) = found[k].idx;
            centre += points.row(neighbours(i, k));
        }
        centre /= static_cast<double>(width);
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (Eigen::Index k = 0; k < width; ++k) {
            const Eigen::RowVector3d offset = points.row(neighbours(i, k)) - centre;
            covariance += offset.transpose() * offset;
        }
        normals.row(i) = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0).transpose();
        if (hint.rows() == count && normals.row(i).dot(hint.row(i)) < 0) normals.row(i) *= -1.0;
    }
    if (hint.rows() != count) orient_by_propagation(points, neighbours, spacings.mean(), normals);
    return normals;
}

}  // namespace ndg
