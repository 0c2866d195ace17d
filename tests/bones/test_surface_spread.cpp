// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/surface_spread.h"
#include "ndg/core/threads.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("A push becomes a smooth bump about it, for any number of threads")
{
    const Template tube = test::tube_template(41, 24);
    const int count = tube.num_wrap_vertices();
    const Points wrap = tube.rest.volume_vertices.topRows(count);
    const double edge = (wrap.row(0) - wrap.row(1)).norm(), width = 5 * edge;
    const SurfaceSpread spread(wrap, tube.wrap_triangles, width, 0.5 * edge);
    const int source = 20 * 24 + 3;
    const Eigen::RowVector3d push(0.01, 0, 0);
    Points vectors = Points::Zero(count, 3);
    vectors.row(source) = push;
    const std::vector<int> moved = spread.spread({source}, width, vectors);
    CHECK(moved.size() > 10);
    for (int v = 0; v < count; ++v) {
        const double far = (wrap.row(v) - wrap.row(source)).norm();
        if (far > width + edge) CHECK(vectors.row(v).isZero(0));
        CHECK(vectors.row(v).norm() <= vectors.row(source).norm() + 1e-12);
        CHECK(vectors(v, 0) >= 0);
    }

    // Where all around are pushed alike, all of the push comes out.
    Points alike = Points::Zero(count, 3);
    std::vector<int> all;
    for (int v = 0; v < count; ++v) all.push_back(v);
    alike.rowwise() = push;
    spread.spread(all, width, alike);
    CHECK((alike.rowwise() - push).cwiseAbs().maxCoeff() < 1e-8);

    Points again = Points::Zero(count, 3);
    again.row(source) = push;
    const int threads = num_threads();
    set_num_threads(threads == 1 ? 3 : 1);
    spread.spread({source}, width, again);
    set_num_threads(threads);
    CHECK((again - vectors).cwiseAbs().maxCoeff() == 0);
}
