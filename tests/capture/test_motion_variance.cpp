// SPDX-License-Identifier: Apache-2.0
// What is measured of captured motions.
#include "tube_capture.h"

#include "ndg/capture/measure_motion.h"
#include "ndg/capture/motion_variance.h"
#include "ndg/core/error.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("Variances of an oscillation are half its squared amplitudes, wherever its middle is")
{
    Points rest(2, 3), normals(2, 3);
    rest << 1, 2, 3, -4, 5, 6;
    normals << 0, 2, 0, 1, 0, -1;
    MotionVarianceSum sum(rest, normals);
    constexpr int count = 40;
    const Eigen::RowVector3d along = Eigen::RowVector3d(1, 0, -1).normalized(), across(0, 1, 0);
    for (int f = 0; f < count; ++f) {
        const double phase = 2 * M_PI * f / count;
        Points frame = rest;
        frame.row(0) += Eigen::RowVector3d(0.03 * std::sin(2 * phase), 0.01 * std::cos(phase) + 0.5, 0);
        frame.row(1) += 0.02 * std::sin(phase) * along + 0.04 * std::cos(3 * phase) * across - 0.1 * along;
        sum.add(frame);
    }
    const MotionVariance variance = sum.variance();
    CHECK(variance.normal[0] == Approx(0.5 * 0.01 * 0.01).epsilon(1e-9));
    CHECK(variance.tangent[0] == Approx(0.5 * 0.03 * 0.03).epsilon(1e-9));
    CHECK(variance.normal[1] == Approx(0.5 * 0.02 * 0.02).epsilon(1e-9));
    CHECK(variance.tangent[1] == Approx(0.5 * 0.04 * 0.04).epsilon(1e-9));
    CHECK((sum.mean().row(0) - rest.row(0) - Eigen::RowVector3d(0, 0.5, 0)).norm() < 1e-12);
    CHECK(variance.stacked().size() == 4);
    CHECK(variance.stacked()[3] == variance.tangent[1]);

    // The isotropic metric does not see what is along the normal instead of across it.
    const MotionVariance turned{variance.tangent, variance.normal};
    CHECK(variance_error(variance, turned, VarianceMetric::isotropic) < 1e-24);
    CHECK(variance_error(variance, turned, VarianceMetric::anisotropic) ==
          Approx(2 * (variance.normal - variance.tangent).squaredNorm()));
    REQUIRE_THROWS_AS(MotionVarianceSum(rest, Points::Zero(2, 3)), Error);
    REQUIRE_THROWS_AS(MotionVarianceSum(rest, normals).variance(), Error);
}

TEST_CASE("Skin that follows its skinning has no variance, and what it does besides is seen in unposed space")
{
    const Template tube = test::tube_template(7, 8);
    const Avatar avatar = test::tube_avatar(tube);
    const MeasuredSkin skin(avatar);
    REQUIRE(skin.size() == tube.num_wrap_vertices());
    CaptureSequence sequence = test::skinned_tube(avatar, 40);
    const MotionVariance still = motion_variance(avatar, skin, sequence);
    CHECK(still.total().maxCoeff() < 1e-24);

    const AvatarPoser poser(avatar);
    for (std::size_t f = 0; f < sequence.vertices.size(); ++f) {
        const Points unposed = avatar.rest + 0.01 * std::sin(2 * M_PI * double(f) / 40) * avatar.normals;
        sequence.vertices[f] =
            to_world(poser.world_from_unposed(sequence.poses[f]), unposed).bottomRows(avatar.skin_vertices.rows());
    }
    const MotionVariance breathing = motion_variance(avatar, skin, sequence);
    CHECK((breathing.normal.array() - 0.5e-4).abs().maxCoeff() < 1e-12);
    CHECK(breathing.tangent.maxCoeff() < 1e-14);

    Capture capture = test::tube_capture(avatar, 40);
    capture.sequences = {sequence};
    const std::vector<MotionMeasure> measures = measure_motion(avatar, skin, capture, nullptr);
    REQUIRE(measures.size() == 1);
    CHECK(measures[0].skinned_error(VarianceMetric::anisotropic) == Approx(skin.size() * 0.25e-8));
    CHECK(measures[0].liveliest.captured.col(0).maxCoeff() == Approx(0.01));
    CHECK(measures[0].liveliest.captured.rightCols(2).norm() < 1e-9);
    REQUIRE_THROWS_AS(measures[0].reduction(VarianceMetric::anisotropic), Error);
    CHECK(motion_measures_json("tube", measures).find("\"captured_normal_rms_mm\": 7.07") != std::string::npos);

    sequence.poses.clear();
    REQUIRE_THROWS_AS(motion_variance(avatar, skin, sequence), InputError);
}
