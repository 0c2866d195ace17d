// SPDX-License-Identifier: Apache-2.0
// Generation of samples: shards, interruption, resumption.
#include "ndg/fem/simulate.h"
#include "fem/sample_scene.h"
#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/fem/sample_parts.h"

#include <catch2/catch.hpp>

#include <atomic>
#include <filesystem>
#include <fstream>

using namespace ndg;
using test::require_same_samples;
using test::SampleScene;
namespace fs = std::filesystem;

TEST_CASE("Shards are parsed and take every n-th pair")
{
    const SampleScene scene;
    const Shard shard = parse_shard("2/3");
    REQUIRE(shard.index == 2);
    REQUIRE(shard.count == 3);
    for (const char* wrong : {"", "3/3", "-1/3", "1", "1/0", "1/3x", "a/b"}) {
        REQUIRE_THROWS_AS(parse_shard(wrong), InputError);
    }
    const auto tasks = sample_tasks(scene.splits, Shard{0, 3});
    REQUIRE(tasks.size() == 2);
    REQUIRE(tasks[1].sample_idx == 3);
    REQUIRE(tasks[1].split == "test");
    REQUIRE(tasks[1].pair.body_idx == 1);
    REQUIRE_THROWS_AS(sample_tasks(scene.splits, Shard{5, 9}), InputError);
}

TEST_CASE("One run and two threads give the same samples")
{
    const SampleScene scene;
    set_num_threads(1);
    const DeformationSet whole = scene.run(Shard{}, scene.output);
    REQUIRE(whole.size() == 4);
    REQUIRE(whole.method == "FEM");
    REQUIRE(fs::exists(scene.output));
    REQUIRE_FALSE(fs::exists(scene.output + ".parts"));
    const SimulationSummary summary = summarize_simulation(whole);
    REQUIRE(summary.samples == 4);
    REQUIRE(summary.converged_share == 1);
    REQUIRE(summary.iterations_mean > 1);
    require_same_samples(open_deformations(scene.output, scene.tube.num_volume_vertices()), whole);

    set_num_threads(2);
    require_same_samples(scene.run(Shard{}, scene.folder.file("two.h5")), whole);
}

TEST_CASE("An interrupted run goes on where it stopped; damaged and foreign parts are simulated again")
{
    const SampleScene scene;
    set_num_threads(1);
    const DeformationSet expected = scene.run(Shard{}, scene.folder.file("whole.h5"));

    int asked = 0;
    REQUIRE_THROWS_AS(scene.run(Shard{}, scene.output, [&] { return ++asked > 2; }), Interrupted);
    REQUIRE_FALSE(fs::exists(scene.output));
    const std::string parts = scene.output + ".parts/";
    REQUIRE(fs::exists(parts + "000000.h5"));
    REQUIRE(fs::exists(parts + "000001.h5"));
    REQUIRE_FALSE(fs::exists(parts + "000002.h5"));

    // The second run is asked to stop before every sample it simulates: one asks after the two reused ones.
    fs::resize_file(parts + "000001.h5", fs::file_size(parts + "000001.h5") / 2);
    asked = 0;
    require_same_samples(scene.run(Shard{}, scene.output, [&] { return ++asked > 3; }), expected);
    REQUIRE(asked == 3);
    REQUIRE_FALSE(fs::exists(scene.output + ".parts"));

    // The finished file is taken as it is, and is not replaced by samples of other material.
    asked = 0;
    require_same_samples(scene.run(Shard{}, scene.output, [&] { return ++asked > 0; }), expected);
    REQUIRE(asked == 0);
    SampleScene stiff;
    stiff.options.material.young_fat_pascal *= 3;
    REQUIRE_THROWS_AS(stiff.run(Shard{}, scene.output), InputError);

    // Nor are parts of other material taken or thrown away unasked.
    const std::string other = scene.folder.file("other.h5");
    REQUIRE_THROWS_AS(stiff.run(Shard{}, other, [&] { return ++asked > 2; }), Interrupted);
    REQUIRE_THROWS_AS(scene.run(Shard{}, other), InputError);
    REQUIRE(fs::exists(other + ".parts/000001.h5"));
    require_same_samples(scene.run(
                             Shard{}, other, [] { return false; }, true),
                         expected);
}

TEST_CASE("Wrong pairs and options are input errors")
{
    SampleScene scene;
    const std::vector<SampleTask> tasks = {{0, {2, 0}, "train"}};
    REQUIRE_THROWS_AS(simulate_samples(scene.tube, scene.bodies, scene.poses, tasks, scene.options, scene.output,
                                       Provenance{}, [] { return false; }),
                      InputError);
    scene.options.material.poisson_ratio = 0.6;
    REQUIRE_THROWS_AS(scene.run(Shard{}, scene.output), InputError);
    REQUIRE_FALSE(fs::exists(scene.output));
}
