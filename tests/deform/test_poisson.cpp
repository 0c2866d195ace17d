// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/deform/poisson.h"
#include "ndg/geometry/prism.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

Points jittered(const Points& points, double spread)
{
    Points result = points;
    Random random(5, "poisson-jitter");
    for (Eigen::Index i = 0; i < result.size(); ++i) result.data()[i] += spread * random.normal();
    return result;
}

double largest_distance(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

PoissonReconstruction make_poisson(const Template& tube)
{
    return PoissonReconstruction(RestOperators(tube.prisms, tube.rest.volume_vertices), tube.num_wrap_vertices());
}

}  // namespace

TEST_CASE("Vertices come back from their own deformation gradients")
{
    const Template tube = test::tube_template(9, 7);
    const PoissonReconstruction poisson = make_poisson(tube);
    const auto to_gradients = gradient_operator(tube.rest.volume_vertices, tube.prisms);
    const Points deformed = jittered(tube.rest.volume_vertices, 0.02);
    const Gradients gradients = deformation_gradients(to_gradients, deformed);
    REQUIRE((gradients - deformation_gradients(to_gradients, tube.rest.volume_vertices)).norm() > 1);
    const Points bone_wrap = deformed.topRows(tube.num_wrap_vertices());
    REQUIRE(largest_distance(poisson.reconstruct(gradients, bone_wrap), deformed) < 1e-10);
    const GradientsF single = gradients.cast<float>();
    REQUIRE(largest_distance(poisson.reconstruct(single, bone_wrap), deformed) < 1e-5);
}

TEST_CASE("The reconstruction minimises the weighted squared difference of gradients")
{
    // Against dense normal equations of the stacked operator, with gradients that no shape has.
    const Template tube = test::tube_template(4, 5);
    const PoissonReconstruction poisson = make_poisson(tube);
    const int fixed = tube.num_wrap_vertices(), free = 2 * fixed;
    const Eigen::MatrixXd g = gradient_operator(tube.rest.volume_vertices, tube.prisms);
    const Eigen::VectorXd volumes = prism_volumes(tube.rest.volume_vertices, tube.prisms);
    Gradients target(tube.num_prisms(), 9);
    Random random(1, "poisson-target");
    for (Eigen::Index i = 0; i < target.size(); ++i) target.data()[i] = random.normal();
    Eigen::MatrixXd stacked(3 * tube.num_prisms(), 3);
    Eigen::VectorXd weights(3 * tube.num_prisms());
    for (Eigen::Index p = 0; p < tube.num_prisms(); ++p) {
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) stacked(3 * p + j, i) = target(p, 3 * i + j);
            weights(3 * p + i) = volumes(p);
        }
    }
    const Points bone_wrap = tube.rest.volume_vertices.topRows(fixed);
    const Eigen::MatrixXd g_free = g.rightCols(free), remaining = stacked - g.leftCols(fixed) * bone_wrap;
    const Eigen::MatrixXd weighted = weights.asDiagonal() * g_free;
    const Eigen::MatrixXd expected = (weighted.transpose() * g_free).ldlt().solve(weighted.transpose() * remaining);
    const Points result = poisson.reconstruct(target, bone_wrap);
    REQUIRE(largest_distance(result.topRows(fixed), bone_wrap) == 0);
    REQUIRE((result.bottomRows(free) - expected).norm() < 1e-9 * expected.norm());
}

TEST_CASE("Another body of the same template reuses the object")
{
    const Template tube = test::tube_template(5, 6);
    PoissonReconstruction poisson = make_poisson(tube);
    const Points other = 1.3 * jittered(tube.rest.volume_vertices, 0.001);
    poisson.set_rest(RestOperators(tube.prisms, other));
    const PoissonReconstruction fresh(RestOperators(tube.prisms, other), tube.num_wrap_vertices());
    const std::vector<Eigen::Matrix3d> rotations(static_cast<std::size_t>(tube.num_prisms()),
                                                 Eigen::Matrix3d::Identity());
    const Points bone_wrap = other.topRows(tube.num_wrap_vertices());
    REQUIRE(largest_distance(poisson.reconstruct(rotations, bone_wrap), other) < 1e-10);
    REQUIRE((poisson.reconstruct(rotations, bone_wrap) - fresh.reconstruct(rotations, bone_wrap)).norm() == 0);
    const Template longer = test::tube_template(6, 6);
    REQUIRE_THROWS_AS(poisson.set_rest(RestOperators(longer.prisms, longer.rest.volume_vertices)), Error);
    REQUIRE_THROWS_AS(poisson.reconstruct(rotations, other), Error);
}
