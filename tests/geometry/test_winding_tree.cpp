// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/winding_tree.h"

#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/closest_point.h"

#include <catch2/catch.hpp>

using namespace ndg;
using test::Surface;

namespace {

Eigen::Vector3d random_point(Random& random, double range)
{
    return {random.uniform(-range, range), random.uniform(-range, range), random.uniform(-range, range)};
}

}  // namespace

TEST_CASE("the hierarchy of winding numbers agrees with the direct sum")
{
    // A long dented body, open below: cells of every shape, far and near, and values between 0 and 1.
    Surface body = test::icosphere(1.0, 4);
    for (Eigen::Index v = 0; v < body.vertices.rows(); ++v) {
        const Eigen::RowVector3d d = body.vertices.row(v);
        body.vertices.row(v) *= 1.0 + 0.3 * std::sin(7.0 * d.x()) * std::cos(5.0 * d.z());
        body.vertices(v, 1) *= 4.0;
    }
    const Triangles open = body.triangles.topRows(body.triangles.rows() - 300);
    Random random(35, "winding tree");
    Points points(500, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        points.row(i) = random_point(random, 1.6).transpose();
        points(i, 1) *= 3.0;
        // A fifth of them next to the surface, on either side.
        if (i % 5 == 0) points.row(i) = (i % 2 == 0 ? 0.999 : 1.001) * body.vertices.row(4 * i);
    }
    for (const Triangles& triangles : {body.triangles, open}) {
        const WindingTree tree(body.vertices, triangles);
        const Eigen::VectorXd direct = winding_numbers(body.vertices, triangles, points);
        double worst = 0.0;
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            worst = std::max(worst, std::abs(tree.winding_number(points.row(i).transpose()) - direct[i]));
        CAPTURE(worst);
        CHECK(worst < 0.02);
        CHECK(worst > 0.0);  // or nothing was taken together
    }
    CHECK_THROWS_AS(WindingTree(body.vertices, Triangles(0, 3)), Error);
}
