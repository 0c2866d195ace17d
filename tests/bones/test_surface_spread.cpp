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
    const SurfaceSpread spread(wrap, tube.wrap_triangles, {2 * width, width}, 0.5 * edge);
    const int source = 20 * 24 + 3;
    const Eigen::Vector3f push(0.01F, 0, 0);
    const PointColumnsF flat = PointColumnsF::Zero(4, count);
    PointColumnsF bump = flat;
    SurfaceSpread::Pushes pushes(spread);
    pushes.add(source, 0.5F * push);
    pushes.add(source, push);
    CHECK_FALSE(pushes.empty());
    const std::vector<int> moved = spread.spread(pushes, 1, bump);
    CHECK(pushes.empty());
    CHECK(moved.size() > 10);
    CHECK(bump(0, source) > 0);
    int num_moved = 0;
    for (int v = 0; v < count; ++v) {
        const double far = (wrap.row(v) - wrap.row(source)).norm();
        if (far > width + edge) CHECK(bump.col(v).isZero(0));
        CHECK(bump.col(v).norm() <= bump.col(source).norm() + 1e-9F);
        CHECK(bump(0, v) >= 0);
        num_moved += !bump.col(v).isZero(0);
    }
    CHECK(num_moved <= int(moved.size()));

    // A larger width, a broader bump.
    PointColumnsF broad = flat;
    pushes.add(source, push);
    CHECK(spread.spread(pushes, 0, broad).size() > moved.size());

    // Where all around are pushed alike, all of the push comes out.
    PointColumnsF alike = flat;
    for (int v = 0; v < count; ++v) pushes.add(v, push);
    spread.spread(pushes, 1, alike);
    CHECK((alike.topRows<3>().colwise() - push).cwiseAbs().maxCoeff() < 1e-7F);

    PointColumnsF again = flat;
    const int threads = num_threads();
    set_num_threads(threads == 1 ? 3 : 1);
    pushes.add(source, push);
    spread.spread(pushes, 1, again);
    pushes.add(source, push);
    spread.spread(pushes, 1, again);
    set_num_threads(threads);
    CHECK(again == 2 * bump);
}
