// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/deform/bake_morphs.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

/// A bending tube whose skin bulges in two ways of its own strength each.
struct Bulges {
    Template tube = test::tube_template(9, 8);
    Points first = random_offsets(1), second = random_offsets(2);

    Points random_offsets(int stream) const
    {
        Random random(std::uint64_t(stream), "bulge");
        Points offsets(tube.rest.skin_vertices.rows(), 3);
        for (Eigen::Index i = 0; i < offsets.size(); ++i) offsets.data()[i] = 0.01 * random.normal();
        return offsets;
    }
    double first_weight(int frame) const { return 0.3 * frame; }
    double second_weight(int frame) const { return 1.0 - 0.5 * frame; }
    BakedFrame frame(int f) const
    {
        const std::vector<Eigen::Isometry3d> motions =
            forward_kinematics(tube.skeleton, tube.rest.joint_positions, test::tube_pose(0.3 * f));
        const Points bulged = tube.rest.skin_vertices + first_weight(f) * first + second_weight(f) * second;
        return {motions, linear_blend_skinning(bulged, tube.skin_weights, motions)};
    }
    BakedMorphs bake(int num_frames, int max_morphs) const
    {
        return bake_morphs(tube.rest.skin_vertices, tube.skin_weights, num_frames, max_morphs,
                           [this](int f) { return frame(f); });
    }
};

}  // namespace

TEST_CASE("Two ways to bulge are two morphs; a frame comes out as skinning of the rest shape with them")
{
    const Bulges bulges;
    const BakedMorphs baked = bulges.bake(5, 8);
    REQUIRE(baked.morphs.size() == 2);
    REQUIRE(baked.weights.rows() == 5);
    CHECK(baked.weights.cwiseAbs().colwise().maxCoeff().isApproxToConstant(1.0, 1e-12));
    for (int f = 0; f < 5; ++f) {
        Points shape = bulges.tube.rest.skin_vertices;
        for (int k = 0; k < 2; ++k) shape += baked.weights(f, k) * baked.morphs[k];
        const BakedFrame wanted = bulges.frame(f);
        const Points vertices = linear_blend_skinning(shape, bulges.tube.skin_weights, wanted.world_from_rest);
        const Points skinned =
            linear_blend_skinning(bulges.tube.rest.skin_vertices, bulges.tube.skin_weights, wanted.world_from_rest);
        const Eigen::VectorXd errors = (vertices - wanted.vertices).rowwise().norm();
        CHECK(errors.maxCoeff() < 1e-6);
        CHECK(baked.errors[f].max == Approx(errors.maxCoeff()).margin(1e-12));
        CHECK(baked.skinning_errors[f].mean == Approx((skinned - wanted.vertices).rowwise().norm().mean()));
        CHECK(baked.skinning_errors[f].max > 0.005);
    }
}

TEST_CASE("With fewer morphs than ways to bulge the larger one is kept")
{
    const Bulges bulges;
    const BakedMorphs baked = bulges.bake(5, 1);
    REQUIRE(baked.morphs.size() == 1);
    double with = 0, without = 0;
    for (int f = 0; f < 5; ++f) {
        with += baked.errors[f].mean;
        without += baked.skinning_errors[f].mean;
    }
    CHECK(with < 0.5 * without);
    CHECK(with > 1e-4);
}
