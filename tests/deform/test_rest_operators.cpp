// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_operators.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

Points deformed_tube(const Template& tube)
{
    Points points = tube.rest.volume_vertices;
    Random random(3, "rest-operators");
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] += 0.02 * random.normal();
    return points;
}

}  // namespace

TEST_CASE("Gradients of deformed vertices are those of the stacked operator, in both precisions")
{
    const Template tube = test::tube_template(6, 7);
    const RestOperators rest(tube.prisms, tube.rest.volume_vertices);
    const Points deformed = deformed_tube(tube);
    const Gradients expected =
        deformation_gradients(gradient_operator(tube.rest.volume_vertices, tube.prisms), deformed);
    CHECK((rest.deformation_gradients(deformed) - expected).cwiseAbs().maxCoeff() < 1e-12);
    const PointsF stored = deformed.cast<float>();
    // Of the stored vertices exactly, rounded once at the end.
    const Points widened = stored.cast<double>();
    CHECK(rest.deformation_gradients(stored) == rest.deformation_gradients(widened).cast<float>());
    const Eigen::VectorXd volumes = prism_volumes(tube.rest.volume_vertices, tube.prisms);
    for (int p = 0; p < rest.num_prisms(); ++p) CHECK(rest.volume(p) == volumes[p]);
    CHECK_THROWS_AS(rest.deformation_gradients(Points(deformed.topRows(4))), Error);
}

TEST_CASE("Residuals are gradients seen from the turned prism")
{
    const Template tube = test::tube_template(5, 6);
    const RestOperators rest(tube.prisms, tube.rest.volume_vertices);
    std::vector<Eigen::Matrix3d> rotations;
    for (int p = 0; p < rest.num_prisms(); ++p) {
        rotations.push_back(Eigen::AngleAxisd(0.1 * p, Eigen::Vector3d(1, p, 2).normalized()).toRotationMatrix());
    }
    const Points deformed = deformed_tube(tube);
    const Gradients expected = residuals_from_gradients(rest.deformation_gradients(deformed), rotations);
    CHECK((rest.residuals(deformed, rotations) - expected).cwiseAbs().maxCoeff() < 1e-12);
    const PointsF stored = deformed.cast<float>();
    const Points widened = stored.cast<double>();
    CHECK(rest.residuals(stored, rotations) == rest.residuals(widened, rotations).cast<float>());
    rotations.pop_back();
    CHECK_THROWS_AS(rest.residuals(deformed, rotations), Error);
}

TEST_CASE("A rest prism without volume is named")
{
    const Template tube = test::tube_template(4, 5);
    Points flat = tube.rest.volume_vertices;
    for (int k = 1; k < 6; ++k) flat.row(tube.prisms(2, k)) = flat.row(tube.prisms(2, 0));
    CHECK_THROWS_WITH(RestOperators(tube.prisms, flat), Catch::Contains("rest prism"));
}
