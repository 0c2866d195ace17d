// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/geometry/point_tree.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;

namespace {

Points random_points(int count, std::uint64_t seed)
{
    Random random(seed, "test points");
    Points points(count, 3);
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = random.uniform(-1.0, 1.0);
    return points;
}

}  // namespace

TEST_CASE("the nearest points are those found by comparing all")
{
    const Points points = random_points(700, 1), queries = random_points(60, 2);
    const PointTree tree(points);
    for (Eigen::Index q = 0; q < queries.rows(); ++q) {
        std::vector<std::pair<double, int>> all;
        for (Eigen::Index i = 0; i < points.rows(); ++i) {
            all.emplace_back((points.row(i) - queries.row(q)).squaredNorm(), static_cast<int>(i));
        }
        std::sort(all.begin(), all.end());
        const Eigen::Vector3d query = queries.row(q).transpose();
        CHECK(tree.nearest(query).idx == all[0].second);
        const auto found = tree.nearest(query, 9);
        REQUIRE(found.size() == 9);
        for (std::size_t k = 0; k < 9; ++k) CHECK(found[k].idx == all[k].second);
    }
    CHECK(tree.nearest(Eigen::Vector3d::Zero(), 5000).size() == 700);
}
