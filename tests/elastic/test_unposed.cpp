// SPDX-License-Identifier: Apache-2.0
// Strain of unposed positions: the same energy as a function of world positions.
#include "derivatives.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/elastic/fung_lanes.h"
#include "ndg/elastic/neo_hookean_lanes.h"
#include "ndg/elastic/unposed_term.h"

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>

#include <cmath>

using namespace ndg;

namespace {

struct Cube {
    Points rest{8, 3};
    Tetrahedra cells{6, 4};
    std::vector<AffineMap> maps;  ///< each its own

    Cube()
    {
        for (int v = 0; v < 8; ++v) rest.row(v) << v % 2, v / 2 % 2, v / 4;
        cells << 0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7;
        Random random(2, "maps");
        for (int v = 0; v < 8; ++v) {
            AffineMap map;
            map.leftCols<3>() = Eigen::AngleAxisd(0.8 + 0.2 * v, Eigen::Vector3d(1, 0.3 * v, -1).normalized()).matrix();
            for (int k = 0; k < 9; ++k) map(k) += 0.1 * random.normal();
            map.col(3) << random.normal(), random.normal(), random.normal();
            maps.push_back(map);
        }
    }
};

template <class Law>
std::vector<typename Law::Material> materials();
template <>
std::vector<OrthotropicMaterial> materials<FungLanes>()
{
    return std::vector<OrthotropicMaterial>(6, orthotropic_material({1, 3, 0.2, 4}, Eigen::Vector3d(1, 2, 0)));
}
template <>
std::vector<Lame> materials<NeoHookeanLanes>()
{
    return std::vector<Lame>(6, lame_parameters(2, 0.3));
}

}  // namespace

TEMPLATE_TEST_CASE("An unposed term is the plain term of unposed positions, with its derivatives", "", FungLanes,
                   NeoHookeanLanes)
{
    const Cube cube;
    ElasticBody plain(8, 0), unposed(8, 0);
    plain.add(std::make_unique<FleshTerm<TestType, TetrahedronElement>>(cube.cells, materials<TestType>(), 1.0, 8));
    auto made =
        std::make_unique<UnposedFleshTerm<TestType, TetrahedronElement>>(cube.cells, materials<TestType>(), 1.0, 8);
    UnposedMaps& maps = *made;
    unposed.add(std::move(made));
    plain.set_rest(cube.rest);
    unposed.set_rest(cube.rest);
    const Objective of_plain(plain), of_unposed(unposed);

    Random random(6, "unposed");
    Points u = cube.rest;
    for (int v = 0; v < 8; ++v) {
        for (int c = 0; c < 3; ++c) u(v, c) += 0.2 * random.normal();
    }
    // Before maps are given both are the same.
    REQUIRE(of_unposed.energy(u) == Approx(of_plain.energy(u)).epsilon(1e-14));
    maps.set_world_from_unposed(cube.maps);
    const Points x = apply_maps(cube.maps, u);
    REQUIRE(of_plain.energy(u) > 0.1);
    REQUIRE(of_unposed.energy(x) == Approx(of_plain.energy(u)).epsilon(1e-12));
    REQUIRE(of_unposed.energy(u) != Approx(of_plain.energy(u)).epsilon(1e-3));
    test::require_derivatives(of_unposed, x);

    // Forces do the same work, Hessians the same curvature.
    Points step(8, 3);
    for (int k = 0; k < 24; ++k) step.data()[k] = random.normal();
    Points moved(8, 3);
    for (int v = 0; v < 8; ++v) {
        moved.row(v) = (cube.maps[static_cast<std::size_t>(v)].leftCols<3>() * step.row(v).transpose()).transpose();
    }
    const Eigen::Map<const Eigen::VectorXd> in_unposed(step.data(), 24), in_world(moved.data(), 24);
    Eigen::VectorXd plain_gradient, world_gradient, scratch;
    of_plain.gradient(u, plain_gradient, scratch);
    of_unposed.gradient(x, world_gradient, scratch);
    REQUIRE(world_gradient.dot(in_world) == Approx(plain_gradient.dot(in_unposed)).epsilon(1e-10));
    for (const HessianKind kind : {HessianKind::exact, HessianKind::projected, HessianKind::nearly_exact}) {
        const double plain_curvature = in_unposed.dot(test::hessian_of(of_plain, u, kind) * in_unposed);
        const double world_curvature = in_world.dot(test::hessian_of(of_unposed, x, kind) * in_world);
        REQUIRE(world_curvature == Approx(plain_curvature).epsilon(1e-10));
    }
    // At the skinned shape there is nothing, whatever the maps.
    of_unposed.gradient(apply_maps(cube.maps, cube.rest), world_gradient, scratch);
    REQUIRE(world_gradient.norm() < 1e-13);
    of_plain.gradient(apply_maps(cube.maps, cube.rest), plain_gradient, scratch);
    REQUIRE(plain_gradient.norm() > 0.1);
}

TEST_CASE("Maps that cannot be undone are refused by name, and change nothing")
{
    const Cube cube;
    UnposedFleshTerm<FungLanes, TetrahedronElement> term(cube.cells, materials<FungLanes>(), 1.0, 8);
    term.set_world_from_unposed(cube.maps);
    const AffineMap before = term.unposed_from_world()[2];
    const Points back = apply_maps(term.unposed_from_world(), apply_maps(cube.maps, cube.rest));
    REQUIRE((back - cube.rest).norm() < 1e-12);

    std::vector<AffineMap> maps = cube.maps;
    maps[5].leftCols<3>().setZero();
    REQUIRE_THROWS_WITH(term.set_world_from_unposed(maps), Catch::Contains("vertex 5"));
    maps[5] = -cube.maps[5];
    REQUIRE_THROWS_WITH(term.set_world_from_unposed(maps), Catch::Contains("vertex 5"));
    maps[5] = cube.maps[5];
    maps[7](1, 3) = std::nan("");
    REQUIRE_THROWS_WITH(term.set_world_from_unposed(maps), Catch::Contains("vertex 7"));
    maps.pop_back();
    REQUIRE_THROWS_AS(term.set_world_from_unposed(maps), Error);
    REQUIRE_THROWS_AS(apply_maps(maps, cube.rest), Error);
    REQUIRE(term.unposed_from_world()[2] == before);
}
