// SPDX-License-Identifier: Apache-2.0
// Trained networks, exported for the runtime, against what libtorch makes of them.
#include "ndg/runtime/export_model.h"

#include "ndg/core/error.h"
#include "ndg/neural/network_deformer.h"
#include "ndg/runtime/runtime.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

constexpr RuntimeWeights as_trained{WeightStorage::float32, WeightStorage::float32};

/// Trains a little, exports, and compares some frames, m.
double largest_difference(const NetworkOptions& options, const RuntimeWeights& weights)
{
    const test::Synthetic s = test::make_synthetic(24, 8);
    const test::TemporaryFolder folder;
    NetworkInputs inputs;
    inputs.model_path = folder.file("model.h5");
    test::moved_model(s, options).save(inputs.model_path, Provenance{});
    export_runtime_model(inputs.model_path, weights, folder.file("model.ndg"), Provenance{});
    const BodyPoser poser(s.tube, test::bending);
    NetworkDeformer network(poser, inputs);
    const RuntimeModel model(folder.file("model.ndg"));
    Runtime runtime(s.tube, model);
    double difference = 0, moved = 0;
    for (const int body_idx : {0, 6}) {
        const Body& body = s.bodies.bodies[body_idx];
        runtime.set_body(body);
        for (const int pose_idx : {1, 9}) {
            const PosedBody posed = poser.pose(body, s.poses.poses[pose_idx]);
            const Points expected = network.deform(posed);
            runtime.set_pose(s.poses.poses[pose_idx]);
            difference = std::max(difference, (runtime.volume().cast<double>() - expected).cwiseAbs().maxCoeff());
            moved = std::max(moved, (posed.skinned_volume() - expected).cwiseAbs().maxCoeff());
        }
    }
    CHECK(moved > 1e-3);
    return difference;
}

std::string refusal(const NetworkOptions& options)
{
    const test::Synthetic s = test::make_synthetic(8, 2);
    const test::TemporaryFolder folder;
    s.model(options).save(folder.file("model.h5"), Provenance{});
    try {
        export_runtime_model(folder.file("model.h5"), {}, folder.file("model.ndg"), Provenance{});
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("The runtime poses bodies as libtorch does, to 0.01 mm")
{
    NetworkOptions options = test::small_network();
    SECTION("a network") {}
    SECTION("its bodies not seen")
    {
        options.shape = false;
    }
    SECTION("no rotation")
    {
        options.rotation = false;
    }
    SECTION("no matrix exponential, a fixed basis")
    {
        options.parametrisation = ParametrisationKind::direct;
        options.output_basis = 12;
    }
    SECTION("regional")
    {
        options.region_reach = 1;
    }
    SECTION("regional, a fixed basis each")
    {
        options.region_reach = 1;
        options.output_basis = 6;
    }
    CHECK(largest_difference(options, as_trained) < 1e-5);
}

TEST_CASE("Weights of 8 bits are not exact, but near")
{
    const double difference = largest_difference(test::small_network(), {});
    CHECK(difference > 1e-6);
    CHECK(difference < 1e-3);
}

TEST_CASE("Networks that the runtime does not know are refused in one sentence")
{
    NetworkOptions options = test::small_network();
    options.parametrisation = ParametrisationKind::lu;
    CHECK_THAT(refusal(options), Catch::Contains("model.h5") && Catch::Contains("parametrisation lu"));
    options = test::small_network();
    options.output_space = "vertex-offsets";
    CHECK_THAT(refusal(options), Catch::Contains("vertex-offsets"));
}
