// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/control_points.h"

#include "ndg/core/error.h"
#include "ndg/geometry/point_tree.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

/// Points nearer to the plane than this share of the surface's diameter are their own mirror image.
constexpr double plane_share = 0.01;
/// Smallest area of a vertex over the mean: needles would make the biharmonic matrix worse than singular.
constexpr double least_area_share = 1e-3;

double diameter(const Eigen::Ref<const Points>& vertices)
{
    return (vertices.colwise().maxCoeff() - vertices.colwise().minCoeff()).norm();
}

}  // namespace

ControlPoints place_control_points(const Eigen::Ref<const Points>& vertices, int count, double plane_x)
{
    std::vector<int> half;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        if (vertices(v, 0) >= plane_x) half.push_back(int(v));
    require_input(count >= 1 && std::size_t(count) <= half.size(),
                  "{} control points were asked of a surface with {} vertices on its left half", count, half.size());
    Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
    for (const int v : half) mean += vertices.row(v) / double(half.size());

    std::vector<double> distances(half.size(), std::numeric_limits<double>::max());
    ControlPoints points;
    for (Eigen::RowVector3d newest = mean; points.size() < count;) {
        // The mean is no point of the set: it only names the first.
        const bool first = points.size() == 0;
        std::size_t farthest = 0;
        double largest = -1.0;
        for (std::size_t i = 0; i < half.size(); ++i) {
            const double distance = (vertices.row(half[i]) - newest).squaredNorm();
            const double candidate = first ? distance : distances[i] = std::min(distances[i], distance);
            if (candidate > largest) {
                largest = candidate;
                farthest = i;
            }
        }
        points.vertices.push_back(half[farthest]);
        newest = vertices.row(half[farthest]);
    }

    const PointTree tree(vertices);
    const double near_plane = plane_share * diameter(vertices);
    for (const int v : points.vertices) {
        Eigen::Vector3d image = vertices.row(v).transpose();
        image[0] = 2 * plane_x - image[0];
        const int opposite = tree.nearest(image).idx;
        const bool in_plane = vertices(v, 0) - plane_x <= near_plane || opposite == v;
        const bool taken = std::count(points.vertices.begin(), points.vertices.end(), opposite) > 0 ||
                           std::count(points.mirrored.begin(), points.mirrored.end(), opposite) > 0;
        points.mirrored.push_back(in_plane || taken ? -1 : opposite);
    }
    return points;
}

RowMatrix control_point_weights(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                                const ControlPoints& points)
{
    const Eigen::Index n = vertices.rows();
    const Eigen::SparseMatrix<double> laplacian = cotangent_laplacian(vertices, triangles);
    const Eigen::VectorXd areas = vertex_areas(vertices, triangles);
    const double least_area = least_area_share * areas.mean();
    const Eigen::VectorXd inverse_areas = areas.cwiseMax(least_area).cwiseInverse();
    const Eigen::SparseMatrix<double> bilaplacian =
        Eigen::SparseMatrix<double>(laplacian * inverse_areas.asDiagonal() * laplacian);

    std::vector<int> control(n, -1);  // which control point a vertex is
    for (int c = 0; c < points.size(); ++c)
        for (const int v : {points.vertices[c], points.mirrored[c]})
            if (v >= 0) control[v] = c;
    std::vector<int> place(n, -1);
    int num_free = 0;
    for (Eigen::Index v = 0; v < n; ++v)
        if (control[v] < 0) place[v] = num_free++;

    RowMatrix weights = RowMatrix::Zero(n, points.size());
    for (Eigen::Index v = 0; v < n; ++v)
        if (control[v] >= 0) weights(v, control[v]) = 1.0;
    if (num_free > 0) {
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::MatrixXd right = Eigen::MatrixXd::Zero(num_free, points.size());
        for (Eigen::Index column = 0; column < n; ++column)
            for (Eigen::SparseMatrix<double>::InnerIterator entry(bilaplacian, column); entry; ++entry) {
                const int row = place[entry.row()];
                if (row < 0) continue;
                if (place[column] >= 0)
                    entries.emplace_back(row, place[column], entry.value());
                else
                    right(row, control[column]) -= entry.value();
            }
        Eigen::SparseMatrix<double> matrix(num_free, num_free);
        matrix.setFromTriplets(entries.begin(), entries.end());
        SparseCholesky solver;
        solver.analyze(matrix);
        if (!solver.factorize(matrix))
            throw SolverError(fmt::format("{} control points do not determine a field on the surface", points.size()));
        const Eigen::MatrixXd solution = solver.solve(right);
        for (Eigen::Index v = 0; v < n; ++v)
            if (place[v] >= 0) weights.row(v) = solution.row(place[v]);
    }
    for (Eigen::Index v = 0; v < n; ++v) {
        weights.row(v) = weights.row(v).cwiseMax(0.0);
        weights.row(v) /= weights.row(v).sum();  // at least one, as the raw weights sum to one
    }
    return weights;
}

}  // namespace ndg
