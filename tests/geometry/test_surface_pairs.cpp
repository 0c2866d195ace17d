// SPDX-License-Identifier: Apache-2.0
// Where a surface meets itself: boxes, crossing triangles, distances of its parts and how far they may move.
#include "ndg/core/random.h"
#include "ndg/geometry/box_pairs.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/surface_pairs.h"
#include "ndg/geometry/triangle_crossings.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;

namespace {

PairCorners random_corners(Random& random, double spread)
{
    PairCorners corners;
    for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 3; ++c) corners(a, c) = spread * random.normal();
    return corners;
}

/// Smallest distance over a fine grid of points of both parts.
double sampled_distance(PairKind kind, const PairCorners& x)
{
    constexpr int steps = 60;
    double smallest = 1e30;
    for (int i = 0; i <= steps; ++i) {
        for (int j = 0; j <= steps; ++j) {
            const double s = double(i) / steps, t = double(j) / steps;
            Eigen::RowVector3d gap;
            if (kind == PairKind::edge_edge) {
                gap = x.row(0) + s * (x.row(1) - x.row(0)) - x.row(2) - t * (x.row(3) - x.row(2));
            } else {
                if (i + j > steps) continue;
                gap = x.row(0) - x.row(1) - s * (x.row(2) - x.row(1)) - t * (x.row(3) - x.row(1));
            }
            smallest = std::min(smallest, gap.norm());
        }
    }
    return smallest;
}

/// By cross products: distance of point and plane, or of two lines.
double line_or_plane_distance(PairKind kind, const PairCorners& x)
{
    const Eigen::RowVector3d u = kind == PairKind::edge_edge ? x.row(1) - x.row(0) : x.row(2) - x.row(1);
    const Eigen::RowVector3d v = kind == PairKind::edge_edge ? x.row(3) - x.row(2) : x.row(3) - x.row(1);
    const Eigen::RowVector3d between = kind == PairKind::edge_edge ? x.row(0) - x.row(2) : x.row(0) - x.row(1);
    const Eigen::RowVector3d normal = u.cross(v);
    return std::abs(normal.dot(between)) / normal.norm();
}

}  // namespace

TEST_CASE("Overlapping boxes are found as by comparing each with each")
{
    Random random(5, "boxes");
    Boxes first(600, 6), second(400, 6);
    for (Boxes* boxes : {&first, &second}) {
        for (Eigen::Index i = 0; i < boxes->rows(); ++i) {
            for (int c = 0; c < 3; ++c) {
                (*boxes)(i, c) = random.uniform(-1, 1);
                (*boxes)(i, 3 + c) = (*boxes)(i, c) + (i % 17 == 0 ? 0.8 : 0.1) * random.uniform(0, 1);
            }
        }
    }
    std::vector<std::pair<int, int>> expected;
    for (int i = 0; i < first.rows(); ++i) {
        for (int j = 0; j < second.rows(); ++j) {
            if ((first.row(i).head<3>().array() <= second.row(j).tail<3>().array()).all() &&
                (second.row(j).head<3>().array() <= first.row(i).tail<3>().array()).all()) {
                expected.emplace_back(i, j);
            }
        }
    }
    REQUIRE(expected.size() > 100);
    REQUIRE(overlapping_boxes(first, second) == expected);
    REQUIRE(overlapping_boxes(first, Boxes(0, 6)).empty());
}

TEST_CASE("Crossing triangles are those that exact predicates find")
{
    Random random(6, "triangles");
    Points vertices(240, 3);
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        for (int c = 0; c < 3; ++c) vertices(v, c) = random.uniform(-1, 1);
    // Neighbours along strips share edges and corners.
    Triangles triangles(238, 3);
    for (int t = 0; t < 238; ++t) triangles.row(t) << t, t + 1, t + 2;
    std::vector<std::pair<int, int>> expected = self_intersections(vertices, triangles, true);
    // Those with a common edge do not count here.
    expected.erase(std::remove_if(expected.begin(), expected.end(),
                                  [](const auto& pair) { return pair.second - pair.first == 1; }),
                   expected.end());
    REQUIRE(expected.size() > 50);
    REQUIRE(crossing_triangles(vertices, triangles) == expected);
    const std::vector<int> involved = triangles_of_pairs({{3, 7}, {3, 5}});
    REQUIRE(involved == std::vector<int>{3, 5, 7});
}

TEST_CASE("Distances of points and triangles, edges and edges, with derivatives")
{
    Random random(7, "pairs");
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
        int inside = 0, outside = 0;
        for (int i = 0; i < 200; ++i) {
            const PairCorners x = random_corners(random, 1);
            const PairDistance distance(kind, x);
            const double d = std::sqrt(distance.squared()), sampled = sampled_distance(kind, x);
            REQUIRE(d <= sampled + 1e-12);
            REQUIRE(sampled - d < 0.15);
            REQUIRE(std::abs(distance.weights().sum()) < 1e-12);
            const bool interior = (distance.weights().array().abs() > 0).all();
            (interior ? inside : outside) += 1;
            if (interior) REQUIRE(d == Approx(line_or_plane_distance(kind, x)).epsilon(1e-9));

            const auto gradient = distance.gradient();
            const auto hessian = distance.hessian();
            const double step = 1e-6;
            Eigen::Matrix<double, 12, 1> numeric;
            Eigen::Matrix<double, 12, 12> numeric_hessian;
            for (int k = 0; k < 12; ++k) {
                PairCorners plus = x, minus = x;
                plus(k / 3, k % 3) += step;
                minus(k / 3, k % 3) -= step;
                numeric[k] = (PairDistance(kind, plus).squared() - PairDistance(kind, minus).squared()) / (2 * step);
                numeric_hessian.col(k) =
                    (PairDistance(kind, plus).gradient() - PairDistance(kind, minus).gradient()) / (2 * step);
            }
            REQUIRE((gradient - numeric).norm() < 1e-6 * (1 + gradient.norm()));
            REQUIRE((hessian - numeric_hessian).norm() < 1e-4 * (1 + hessian.norm()));
        }
        REQUIRE(inside > 10);
        REQUIRE(outside > 10);
    }
}

TEST_CASE("No pair passes through itself on the share of its way that is free")
{
    Random random(8, "ways");
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
        int stopped = 0, free = 0;
        for (int i = 0; i < 300; ++i) {
            const PairCorners from = random_corners(random, 1), to = random_corners(random, 1);
            constexpr double least = 0.02;
            const double start = std::sqrt(PairDistance(kind, from).squared());
            const double kept = std::max(start / 3, std::min(0.8 * start, least));
            const double share = collision_free_share(kind, from, to, least);
            REQUIRE(share > 0);
            double nearest = start;
            for (int k = 0; k <= 500; ++k) {
                const PairCorners at = from + share * k / 500.0 * (to - from);
                nearest = std::min(nearest, std::sqrt(PairDistance(kind, at).squared()));
            }
            REQUIRE(nearest >= 0.999 * kept);
            if (share == 1) {
                ++free;
            } else {
                ++stopped;
                REQUIRE(nearest < kept + 0.05 * start);  // and not stopped for nothing
            }
        }
        REQUIRE(stopped > 50);
        REQUIRE(free > 50);
    }
    // A common motion of both is no approach.
    PairCorners x = random_corners(random, 1), moved = x;
    moved.rowwise() += Eigen::RowVector3d(5, -3, 2);
    REQUIRE(collision_free_share(PairKind::edge_edge, x, moved, 0) == 1);
}

TEST_CASE("Close pairs of a surface are all those within reach, without neighbours")
{
    // Two sheets of a 6 x 6 grid, 0.3 apart; each sheet's own parts are 1 wide.
    constexpr int n = 6;
    Points vertices(2 * n * n, 3);
    std::vector<int> corners;
    for (int sheet = 0; sheet < 2; ++sheet) {
        for (int i = 0; i < n * n; ++i) {
            vertices.row(sheet * n * n + i) << i % n + 0.21 * sheet, i / n + 0.13 * sheet, 0.3 * sheet;
            if (i % n == n - 1 || i / n == n - 1) continue;
            const int v = sheet * n * n + i;
            corners.insert(corners.end(), {v, v + 1, v + n, v + 1, v + n + 1, v + n});
        }
    }
    const Triangles triangles =
        Eigen::Map<const Triangles>(corners.data(), static_cast<Eigen::Index>(corners.size()) / 3, 3);
    const SurfaceParts parts(triangles, static_cast<int>(vertices.rows()));
    int points = 0, edges = 0;
    for (const SurfacePair& pair : parts.close_pairs(vertices, 0.31)) {
        const PairDistance distance(pair.kind, pair_corners(vertices, pair.vertices));
        REQUIRE(distance.squared() < 0.31 * 0.31);
        const int first = pair.kind == PairKind::point_triangle ? 1 : 2;
        REQUIRE(pair.vertices[0] / (n * n) != pair.vertices[first] / (n * n));
        (pair.kind == PairKind::point_triangle ? points : edges) += 1;
    }
    REQUIRE(points > 2 * (n - 1) * (n - 1) - 2 * n);
    REQUIRE(edges > n * n);
    REQUIRE(parts.close_pairs(vertices, 0.29).empty());
}
