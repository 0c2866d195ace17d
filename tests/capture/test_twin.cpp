// SPDX-License-Identifier: Apache-2.0
// Captures whose truth is known.
#include "tube_capture.h"

#include "ndg/capture/twin_capture.h"
#include "ndg/dynamics/layered_driven_body.h"
#include "ndg/geometry/rotation.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("Hidden stiffness is positive, varies as asked, and is alike on both sides")
{
    const Template tube = test::symmetric_tube_template(7);
    TwinOptions options;
    options.heterogeneity_metre = 0.1;
    const Eigen::VectorXd stiffness = hidden_stiffness(tube, tube.rest, options, 5);
    REQUIRE(stiffness.size() == tube.num_wrap_vertices());
    CHECK(stiffness.minCoeff() > 0);
    const Eigen::ArrayXd logs = stiffness.array().log();
    const double spread = std::sqrt((logs - logs.mean()).square().mean());
    CHECK(spread > 0.15);
    CHECK(spread < 0.8);
    const Points skin = tube.rest.volume_vertices.bottomRows(tube.num_wrap_vertices());
    int pairs = 0;
    for (Eigen::Index a = 0; a < skin.rows(); ++a) {
        for (Eigen::Index b = 0; b < a; ++b) {
            const Eigen::RowVector3d mirrored(-skin(b, 0), skin(b, 1), skin(b, 2));
            if ((skin.row(a) - mirrored).norm() > 1e-9) continue;
            CHECK(stiffness[a] == Approx(stiffness[b]));
            ++pairs;
        }
    }
    CHECK(pairs > 10);
    CHECK(hidden_stiffness(tube, tube.rest, options, 5) == stiffness);
    CHECK(hidden_stiffness(tube, tube.rest, options, 6) != stiffness);
    const Eigen::VectorXd prisms = prism_stiffness(tube, stiffness);
    CHECK(prisms.size() == tube.num_prisms());
    CHECK(prisms.head(tube.fat_begin()) == prisms.tail(tube.fat_begin()));
    CHECK(prisms.minCoeff() >= stiffness.minCoeff());
}

TEST_CASE("Noise and errors are as large as asked, and the same for the same seed")
{
    const Template tube = test::tube_template(7, 8);
    const Avatar avatar = test::tube_avatar(tube);
    const CaptureSequence truth = test::skinned_tube(avatar, 120);
    TwinOptions options;
    options.noise_millimetre = 2;
    options.pose_error_degrees = 1;
    options.root_error_millimetre = 3;
    const CaptureSequence seen = observed(truth, options, 9, 0);
    double squares = 0, angles = 0, roots = 0, fastest = 0;
    for (std::size_t f = 0; f < truth.vertices.size(); ++f) {
        squares += (seen.vertices[f] - truth.vertices[f]).rowwise().squaredNorm().mean() / 120;
        const auto error = [&](std::size_t frame, std::size_t j) {
            return rotation_vector(truth.poses[frame].parent_from_joint[j].transpose() *
                                   seen.poses[frame].parent_from_joint[j]);
        };
        for (std::size_t j = 0; j < 60; ++j) {
            angles += error(f, j).squaredNorm() / (3 * 60 * 120);
            if (f > 0) fastest = std::max(fastest, (error(f, j) - error(f - 1, j)).norm());
        }
        roots += (seen.poses[f].root_translation - truth.poses[f].root_translation).squaredNorm() / (3 * 120);
    }
    CHECK(std::sqrt(squares) == Approx(2e-3).epsilon(0.1));
    CHECK(std::sqrt(angles) * 180 / M_PI == Approx(1).epsilon(0.15));
    CHECK(std::sqrt(roots) > 1e-3);
    CHECK(std::sqrt(roots) < 6e-3);
    CHECK(fastest * 180 / M_PI < 1);  // slow: a frame's is much like the next one's
    CHECK(observed(truth, options, 9, 0).vertices[50] == seen.vertices[50]);
    CHECK(observed(truth, options, 9, 1).vertices[50] != seen.vertices[50]);
    options.noise_millimetre = options.pose_error_degrees = options.root_error_millimetre = 0;
    CHECK(observed(truth, options, 9, 0).vertices[50] == truth.vertices[50]);
}

TEST_CASE("A layered body of varied stiffness gives way where it is soft, and starts at rest")
{
    const Template tube = test::tube_template(7, 8);
    const int num_wrap = tube.num_wrap_vertices();
    SimulationOptions options;
    options.posing = test::bending;
    Eigen::VectorXd wrap(num_wrap);
    const Points skin = tube.rest.volume_vertices.bottomRows(num_wrap);
    for (int w = 0; w < num_wrap; ++w) wrap[w] = skin(w, 1) > skin.col(1).mean() ? 4 : 0.25;
    LayeredDrivenBody body(tube, tube.rest, options, 1000, prism_stiffness(tube, wrap));
    LayeredDrivenBody alike(tube, tube.rest, options, 1000, Eigen::VectorXd::Ones(tube.num_prisms()));
    LayeredDrivenBody plain(tube, tube.rest, options, 1000);
    const Pose bent = test::tube_pose(0.6);
    const Points varied = body.equilibrium(bent), even = alike.equilibrium(bent), ordinary = plain.equilibrium(bent);
    CHECK((even - ordinary).cwiseAbs().maxCoeff() < 1e-5);
    CHECK((varied - even).cwiseAbs().maxCoeff() > 1e-5);
    const Objective objective(body.elastic());
    Eigen::VectorXd gradient, absolute;
    objective.gradient(varied, gradient, absolute);
    CHECK(gradient.norm() < 1e-4 * absolute.norm());
    objective.gradient(even, gradient, absolute);
    CHECK(gradient.norm() > 1e-3 * absolute.norm());
}
