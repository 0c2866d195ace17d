// SPDX-License-Identifier: Apache-2.0
// Stiffness from motions whose stiffness is known.
#include "../dynamics/soft_shapes.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/estimation/estimate_tissue.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

using namespace ndg;

namespace {

struct Fixture {
    Template tube = test::tube_template(5, 6);
    VarianceProblem problem;
    RowMatrix weights;
    std::vector<TargetMotion> motions;
    EstimationOptions options;
    test::TemporaryFolder folder;

    Fixture()
    {
        const int num_wrap = tube.num_wrap_vertices();
        problem.tissue = test::soft_tube(tube, 8e3, 15e3);
        problem.poser = test::tube_poser(tube);
        problem.dynamics.newton = {1e-8, 1e-9, 100};
        for (int v = 2 * num_wrap; v < 3 * num_wrap; ++v) problem.volume_vertices.push_back(v);
        problem.normals = problem.tissue.normals.bottomRows(num_wrap);
        const Points& rest = tube.rest.volume_vertices;
        const double low = rest.col(1).minCoeff(), high = rest.col(1).maxCoeff();
        weights.resize(rest.rows(), 2);
        weights.col(1) = (rest.col(1).array() - low) / (high - low);
        weights.col(0) = 1 - weights.col(1).array();
        motions = {swing("bend", 0.5, 0), swing("hop", 0.1, 0.04)};
    }
    TargetMotion swing(const std::string& name, double angle, double height) const
    {
        TargetMotion motion;
        motion.name = name;
        for (int n = 0; n <= 48; ++n) {
            Pose pose = test::tube_pose(angle * std::sin(2 * M_PI * 4 * n / 120.0));
            pose.root_translation = Eigen::Vector3d(0.02, height, 0.01) * std::sin(2 * M_PI * 5 * n / 120.0);
            motion.poses.push_back(pose);
            if (n % 2 == 0) motion.frame_steps.push_back(n);
        }
        return motion;
    }
    /// What would be captured of these moduli, Pa.
    void capture(TissueMaterial material, const std::vector<double>& pascals)
    {
        Eigen::VectorXd truth(static_cast<Eigen::Index>(pascals.size()));
        for (std::size_t p = 0; p < pascals.size(); ++p) truth[static_cast<Eigen::Index>(p)] = std::log(pascals[p]);
        for (TargetMotion& motion : motions) {
            motion.captured = tissue_variance(problem, motion, {weights, material}, truth, false).variance;
        }
    }
};

}  // namespace

TEST_CASE_METHOD(Fixture, "Moduli that made a motion are found again, of either material")
{
    options.prior = 0;
    options.cost_tolerance = 1e-9;
    options.max_iterations = 40;
    capture(TissueMaterial::anisotropic, {4e3, 7e3, 12e3, 20e3});
    const TissueEstimate both = estimate_tissue(problem, motions, weights, options);
    CHECK(both.error < 1e-6);
    CHECK(both.uniform_error > 10 * both.error);
    CHECK(both.uniform_error < 1);
    CHECK(both.young_normal_pascal[0] == Approx(4e3).epsilon(0.02));
    CHECK(both.young_normal_pascal[1] == Approx(7e3).epsilon(0.02));
    CHECK(both.young_tangent_pascal[0] == Approx(12e3).epsilon(0.02));
    CHECK(both.young_tangent_pascal[1] == Approx(20e3).epsilon(0.02));
    const std::vector<double> again = estimated_errors(problem, motions, weights, both.young_normal_pascal,
                                                       both.young_tangent_pascal, options.metric());
    CHECK(again[0] == Approx(both.sequence_errors[0]).margin(1e-9));
    for (std::size_t i = 1; i < both.iterations.size(); ++i) {
        if (both.iterations[i].stage != both.iterations[i - 1].stage) continue;
        CHECK(both.iterations[i].cost < both.iterations[i - 1].cost);
    }

    capture(TissueMaterial::isotropic, {6e3, 14e3});
    for (const EstimationConfiguration configuration : {EstimationConfiguration::ca, EstimationConfiguration::cb}) {
        options.configuration = configuration;
        const TissueEstimate one = estimate_tissue(problem, motions, weights, options);
        CHECK(one.young_normal_pascal == one.young_tangent_pascal);
        CHECK(one.young_normal_pascal[0] == Approx(6e3).epsilon(0.02));
        CHECK(one.young_normal_pascal[1] == Approx(14e3).epsilon(0.02));
    }
}

TEST_CASE_METHOD(Fixture, "An estimation that is broken off after any iteration goes on to the same bits")
{
    options.configuration = EstimationConfiguration::cb;
    capture(TissueMaterial::anisotropic, {4e3, 7e3, 12e3, 20e3});
    const TissueEstimate whole = estimate_tissue(problem, motions, weights, options);
    REQUIRE(whole.iterations.size() > 4);
    EstimationRun run;
    run.checkpoint = folder.file("checkpoint");
    run.key = "tube";
    run.stop = [] { return true; };
    int interruptions = 0;
    TissueEstimate resumed;
    for (bool done = false; !done;) {
        try {
            resumed = estimate_tissue(problem, motions, weights, options, run);
            done = true;
        } catch (const Interrupted&) {
            REQUIRE(++interruptions < 40);
        }
    }
    CHECK(interruptions == static_cast<int>(whole.iterations.size()));
    REQUIRE(resumed.iterations.size() == whole.iterations.size());
    CHECK(resumed.young_normal_pascal == whole.young_normal_pascal);
    CHECK(resumed.error == whole.error);
    CHECK(resumed.iterations[3].parameters == whole.iterations[3].parameters);
    run.key = "another";
    REQUIRE_THROWS_WITH(estimate_tissue(problem, motions, weights, options, run), Catch::Contains("other inputs"));
    write_file(run.checkpoint, "{");
    REQUIRE_THROWS_AS(estimate_tissue(problem, motions, weights, options, run), InputError);
    run.force = true;
    REQUIRE_THROWS_AS(estimate_tissue(problem, motions, weights, options, run), Interrupted);  // begins anew
}

TEST_CASE_METHOD(Fixture, "What cannot be estimated from is refused")
{
    REQUIRE_THROWS_AS(estimate_tissue(problem, {}, weights, options), InputError);
    capture(TissueMaterial::isotropic, {6e3, 14e3});
    options.start_young_pascal = 1;
    REQUIRE_THROWS_WITH(estimate_tissue(problem, motions, weights, options), Catch::Contains("--least-young"));
    options.start_young_pascal = 10e3;
    for (TargetMotion& motion : motions) {
        motion.captured.normal.setZero();
        motion.captured.tangent.setZero();
    }
    REQUIRE_THROWS_WITH(estimate_tissue(problem, motions, weights, options), Catch::Contains("does not move"));
}
