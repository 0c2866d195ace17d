// SPDX-License-Identifier: Apache-2.0
// Generation of samples: shards, interruption, resumption.
#include "ndg/fem/simulate.h"
#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/fem/sample_parts.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <atomic>
#include <filesystem>
#include <fstream>

using namespace ndg;

namespace {

namespace fs = std::filesystem;

struct Scene {
    Template tube = test::tube_template(5, 5);
    BodySet bodies;
    PoseSet poses;
    Splits splits;
    SimulationOptions options;
    test::TemporaryFolder folder;
    std::string output = folder.file("samples.h5");

    Scene()
    {
        for (const double scale : {1.0, 1.2}) {
            Body body = tube.rest;
            for (Points* points :
                 {&body.volume_vertices, &body.skin_vertices, &body.interior_vertices, &body.joint_positions}) {
                *points *= scale;
            }
            bodies.bodies.push_back(body);
        }
        for (const double angle : {0.2, -0.4, 0.6, 0.8}) poses.poses.push_back(test::tube_pose(angle));
        splits.bodies = {{"train", {0}}, {"validation", {}}, {"test", {1}}};
        splits.poses = {{"train", {0, 1, 2}}, {"validation", {}}, {"test", {3}}};
        splits.pairs = {{"train", {{0, 0}, {0, 1}, {0, 2}}}, {"validation", {}}, {"test", {{1, 3}}}};
    }

    DeformationSet run(
        const Shard& shard, const std::string& path, const std::function<bool()>& stop = [] { return false; }) const
    {
        return simulate_samples(tube, bodies, poses, sample_tasks(splits, shard), options, path, Provenance{}, stop);
    }
};

void require_same_samples(const DeformationSet& a, const DeformationSet& b)
{
    REQUIRE(a.size() == b.size());
    REQUIRE(a.vertices == b.vertices);
    REQUIRE(a.pair_splits == b.pair_splits);
    for (std::size_t i = 0; i < a.pairs.size(); ++i) {
        REQUIRE(a.pairs[i].body_idx == b.pairs[i].body_idx);
        REQUIRE(a.pairs[i].pose_idx == b.pairs[i].pose_idx);
    }
    for (const std::string& name : simulation_statistics()) {
        if (name != "seconds") REQUIRE(a.statistics.at(name) == b.statistics.at(name));
    }
}

}  // namespace

TEST_CASE("Shards are parsed and take every n-th pair")
{
    const Scene scene;
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

TEST_CASE("One run, two threads and merged shards give the same samples")
{
    const Scene scene;
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
    require_same_samples(read_deformations(scene.output, scene.tube.num_volume_vertices()), whole);

    set_num_threads(2);
    require_same_samples(scene.run(Shard{}, scene.folder.file("two.h5")), whole);
    std::vector<std::string> shards;
    for (int i = 0; i < 3; ++i) {
        shards.push_back(scene.folder.file("shard" + std::to_string(i) + ".h5"));
        scene.run(Shard{i, 3}, shards.back());
    }
    require_same_samples(merge_shards(shards, scene.splits), whole);
    REQUIRE_THROWS_AS(merge_shards({shards[0], shards[1]}, scene.splits), InputError);
    REQUIRE_THROWS_AS(merge_shards({shards[0], shards[1], shards[2], shards[2]}, scene.splits), InputError);
}

TEST_CASE("An interrupted run goes on where it stopped; damaged and foreign parts are simulated again")
{
    const Scene scene;
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

    // Other material: its parts must not be taken.
    Scene stiff;
    stiff.options.material.young_fat_pascal *= 3;
    asked = 0;
    REQUIRE_THROWS_AS(stiff.run(Shard{}, scene.output, [&] { return ++asked > 2; }), Interrupted);
    require_same_samples(scene.run(Shard{}, scene.output), expected);
}

TEST_CASE("Wrong pairs and options are input errors")
{
    Scene scene;
    const std::vector<SampleTask> tasks = {{0, {2, 0}, "train"}};
    REQUIRE_THROWS_AS(simulate_samples(scene.tube, scene.bodies, scene.poses, tasks, scene.options, scene.output,
                                       Provenance{}, [] { return false; }),
                      InputError);
    scene.options.material.poisson_ratio = 0.6;
    REQUIRE_THROWS_AS(scene.run(Shard{}, scene.output), InputError);
    REQUIRE_FALSE(fs::exists(scene.output));
}
