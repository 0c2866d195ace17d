// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/residuals.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/deform/posed_body.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("Residuals and gradients are each other's inverse")
{
    const Template tube = test::tube_template(5, 5);
    const BodyPoser poser(tube, test::bending);
    const std::vector<Eigen::Matrix3d> rotations = poser.pose(tube.rest, test::tube_pose(1)).prism_rotations();
    Gradients gradients(tube.num_prisms(), 9);
    Random random(2, "residuals");
    for (Eigen::Index i = 0; i < gradients.size(); ++i) gradients.data()[i] = random.normal();
    const Gradients residuals = residuals_from_gradients(gradients, rotations);
    REQUIRE((residuals - gradients).norm() > 0.1);
    REQUIRE((gradients_from_residuals(residuals, rotations) - gradients).norm() < 1e-12);
    GradientsF single = residuals.cast<float>();
    rotate_residuals_in_place(single.data(), rotations);
    REQUIRE((single.cast<double>() - gradients).norm() < 1e-4);
    // A rotation alone leaves the identity.
    Gradients rigid(tube.num_prisms(), 9);
    for (Eigen::Index p = 0; p < rigid.rows(); ++p) {
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rigid.row(p).data()) = rotations[p];
    }
    const Gradients identity = residuals_from_gradients(rigid, rotations);
    Eigen::Matrix<double, 1, 9> row;
    row << 1, 0, 0, 0, 1, 0, 0, 0, 1;
    REQUIRE((identity.rowwise() - row).norm() < 1e-12);
    REQUIRE_THROWS_AS(residuals_from_gradients(gradients.topRows(2), rotations), Error);
}
