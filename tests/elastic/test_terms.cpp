// SPDX-License-Identifier: Apache-2.0
// The law of the prisms on tetrahedra: an objective of another kind of element.
#include "derivatives.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/elastic/flesh_term.h"
#include "ndg/elastic/neo_hookean.h"
#include "ndg/elastic/neo_hookean_lanes.h"

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>

using namespace ndg;

namespace {

/// The unit cube in six tetrahedra about the diagonal from vertex 0 to vertex 7; vertex 4 z + 2 y + x.
struct Cube {
    Points rest{8, 3};
    Tetrahedra cells{6, 4};
    std::vector<Lame> lame;

    Cube()
    {
        for (int v = 0; v < 8; ++v) rest.row(v) << v % 2, v / 2 % 2, v / 4;
        cells << 0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7;
        for (int e = 0; e < 6; ++e) lame.push_back(lame_parameters(e % 2 == 0 ? 45e3 : 15e3, 0.47));
    }
    /// The vertices of the face z = 0 are fixed.
    ElasticBody elastic(double stiffness) const
    {
        ElasticBody body(8, 4);
        body.add(std::make_unique<FleshTerm<NeoHookeanLanes, TetrahedronElement>>(cells, lame, stiffness, 8));
        body.set_rest(rest);
        return body;
    }
};

}  // namespace

TEST_CASE("Tetrahedra of the prisms' material: energy of an affine deformation, derivatives")
{
    const Cube cube;
    const ElasticBody elastic = cube.elastic(1.5);
    const Objective objective(elastic);
    Eigen::Matrix3d f;
    f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.05, 0.1, 1.2;
    Points x = cube.rest * f.transpose();
    double expected = 0;
    for (const Lame& lame : cube.lame) expected += 1.5 * neo_hookean_energy(f, lame) / 6;
    REQUIRE(expected > 1);
    REQUIRE(objective.energy(x) == Approx(expected).epsilon(1e-12));
    REQUIRE(std::abs(objective.energy(cube.rest)) < 1e-12 * expected);

    Random random(3, "tetrahedra");
    for (const double spread : {0.1, 0.4}) {  // the second turns some inside out
        for (int v = 4; v < 8; ++v) {
            for (int c = 0; c < 3; ++c) x(v, c) += spread * random.normal();
        }
        test::require_derivatives(objective, x);
    }
    const Eigen::MatrixXd exact = test::hessian_of(objective, x, HessianKind::exact);
    const Eigen::MatrixXd projected = test::hessian_of(objective, x, HessianKind::projected);
    REQUIRE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(exact).eigenvalues()(0) < 0);
    REQUIRE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(projected).eigenvalues()(0) > -1e-9 * projected.norm());
}

TEST_CASE("Elements without a rest volume, vertices that are not there and bodies of another size are refused")
{
    Cube cube;
    ElasticBody elastic = cube.elastic(1);
    REQUIRE_THROWS_AS(elastic.set_rest(cube.rest.topRows(7)), Error);
    cube.rest.row(7) = cube.rest.row(0);
    REQUIRE_THROWS_WITH(elastic.set_rest(cube.rest), "rest tetrahedron 0 has volume 0 m^3");
    cube.cells(0, 0) = 8;
    REQUIRE_THROWS_AS(cube.elastic(1), Error);
}
