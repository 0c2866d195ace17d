// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/deform/baselines.h"
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

TEST_CASE("Gradient skinning and skinning at rest give the rest shape; under a root motion they move with it")
{
    const Template tube = test::tube_template(7, 6);
    const BodyPoser poser(tube);
    const PoissonReconstruction poisson = make_poisson(tube);
    Pose pose = Pose::rest(tube.skeleton.num_joints());
    auto world_from_rest = poser.world_from_rest(tube.rest, pose);
    REQUIRE(largest_distance(gradient_skinning(poser, poisson, tube.rest, world_from_rest), tube.rest.volume_vertices) <
            1e-10);
    REQUIRE(largest_distance(poser.volume(tube.rest, world_from_rest), tube.rest.volume_vertices) < 1e-12);
    REQUIRE(largest_distance(poser.skin(tube.rest, world_from_rest), tube.rest.skin_vertices) < 1e-12);
    REQUIRE(largest_distance(poser.interior(tube.rest, world_from_rest), tube.rest.interior_vertices) < 1e-12);

    pose.parent_from_joint[0] = Eigen::AngleAxisd(2, Eigen::Vector3d(1, 1, 3).normalized()).toRotationMatrix();
    pose.root_translation = Eigen::Vector3d(0.1, 0.2, 0.3);
    world_from_rest = poser.world_from_rest(tube.rest, pose);
    Points expected = tube.rest.volume_vertices;
    for (Eigen::Index i = 0; i < expected.rows(); ++i) {
        expected.row(i) = (world_from_rest[0] * Eigen::Vector3d(expected.row(i).transpose())).transpose();
    }
    REQUIRE(largest_distance(expected, tube.rest.volume_vertices) > 0.1);
    REQUIRE(largest_distance(gradient_skinning(poser, poisson, tube.rest, world_from_rest), expected) < 1e-10);
    REQUIRE(largest_distance(poser.volume(tube.rest, world_from_rest), expected) < 1e-10);
}

TEST_CASE("The bone wrap of every method is the skinned one; the display skin takes the deformed volume")
{
    const Template tube = test::tube_template(7, 6);
    const BodyPoser poser(tube);
    const PoissonReconstruction poisson = make_poisson(tube);
    const auto world_from_rest = poser.world_from_rest(tube.rest, test::tube_pose(1));
    const Points bone_wrap = poser.bone_wrap(tube.rest, world_from_rest);
    const Points volume = gradient_skinning(poser, poisson, tube.rest, world_from_rest);
    const int fixed = tube.num_wrap_vertices();
    REQUIRE(largest_distance(volume.topRows(fixed), bone_wrap) == 0);
    REQUIRE(largest_distance(poser.volume(tube.rest, world_from_rest).topRows(fixed), bone_wrap) < 1e-12);
    REQUIRE(largest_distance(volume, poser.volume(tube.rest, world_from_rest)) > 1e-3);

    const Points skin = poser.display_skin(tube.rest, world_from_rest, volume);
    const Points skinned = poser.skin(tube.rest, world_from_rest);
    std::vector<char> in_volume(static_cast<std::size_t>(skin.rows()), 0);
    for (int i = 0; i < fixed; ++i) {
        const int vertex = tube.wrap_to_skin[static_cast<std::size_t>(i)];
        in_volume[static_cast<std::size_t>(vertex)] = 1;
        REQUIRE((skin.row(vertex) - volume.row(2 * fixed + i)).norm() == 0);
    }
    for (Eigen::Index v = 0; v < skin.rows(); ++v) {
        if (!in_volume[static_cast<std::size_t>(v)]) REQUIRE((skin.row(v) - skinned.row(v)).norm() == 0);
    }
}

TEST_CASE("Residuals and gradients are each other's inverse")
{
    const Template tube = test::tube_template(5, 5);
    const BodyPoser poser(tube);
    const auto rotations = poser.prism_rotations(poser.world_from_rest(tube.rest, test::tube_pose(1)));
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
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rigid.row(p).data()) =
            rotations[static_cast<std::size_t>(p)];
    }
    const Gradients identity = residuals_from_gradients(rigid, rotations);
    Eigen::Matrix<double, 1, 9> row;
    row << 1, 0, 0, 0, 1, 0, 0, 0, 1;
    REQUIRE((identity.rowwise() - row).norm() < 1e-12);
    REQUIRE_THROWS_AS(residuals_from_gradients(gradients.topRows(2), rotations), Error);
}
