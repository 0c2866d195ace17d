// SPDX-License-Identifier: Apache-2.0
// Shards of a dataset: status, joining, checking; samples that fail; replay.
#include "ndg/fem/sample_shards.h"
#include "fem/sample_scene.h"
#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/fem/replay.h"

#include <unistd.h>
#include <fstream>

#include <filesystem>

using namespace ndg;
using Catch::Contains;
using test::require_same_samples;
using test::SampleScene;
namespace fs = std::filesystem;

namespace {

struct ShardedScene : SampleScene {
    std::string dataset = folder.file("set/fem.h5");
    ShardedScene()
    {
        set_num_threads(1);
        fs::create_directory(folder.file("set"));
    }
    void run_shard(int index, int count) const { run(Shard{index, count}, shard_path(dataset, Shard{index, count})); }
    void run_shards(int count) const
    {
        for (int i = 0; i < count; ++i) run_shard(i, count);
    }
    void overwrite_middle(const std::string& path) const
    {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(fs::file_size(path) / 2));
        const std::string noise(400, 'x');
        file.write(noise.data(), static_cast<std::streamsize>(noise.size()));
    }
};

/// To be changed and written again.
DeformationSet in_memory(const std::string& path)
{
    DeformationSet set = open_deformations(path);
    for (int i = 0; i < set.size(); ++i) set.vertices.push_back(set.coordinates(i));
    set.file.reset();
    return set;
}

}  // namespace

TEST_CASE("Joined shards are the samples of one run, wherever the folder goes")
{
    const ShardedScene scene;
    const DeformationSet whole = scene.run(Shard{}, scene.output);
    scene.run_shards(3);
    require_same_samples(merge_shards(scene.dataset, scene.splits, {}, false), whole);
    REQUIRE(fs::file_size(scene.dataset) < fs::file_size(scene.output) + 20000);
    REQUIRE(check_dataset(scene.dataset, scene.splits).empty());
    REQUIRE(check_dataset(scene.output, scene.splits).empty());

    {  // the dataset and one of its shards can be open at once
        const DeformationSet opened = open_deformations(scene.dataset);
        REQUIRE(opened.coordinates(1) == whole.coordinates(1));
        const DeformationSet shard = open_deformations(shard_path(scene.dataset, Shard{1, 3}));
        REQUIRE(shard.coordinates(0) == whole.coordinates(1));
    }
    const std::string moved = scene.folder.file("moved");
    fs::rename(scene.folder.file("set"), moved);
    require_same_samples(open_deformations(moved + "/fem.h5", scene.tube.num_volume_vertices()), whole);
    REQUIRE(check_dataset(moved + "/fem.h5", scene.splits).empty());

    // A file that holds samples of its own is not replaced by a link to shards.
    fs::rename(moved, scene.folder.file("set"));
    fs::copy_file(scene.output, scene.dataset, fs::copy_options::overwrite_existing);
    REQUIRE_THROWS_WITH(merge_shards(scene.dataset, scene.splits, {}, false), Contains("--force"));
    REQUIRE_NOTHROW(merge_shards(scene.dataset, scene.splits, {}, true));
}

TEST_CASE("Shards that are incomplete, of other options or of two numbers are not joined")
{
    const ShardedScene scene;
    REQUIRE_THROWS_WITH(merge_shards(scene.dataset, scene.splits, {}, false), Contains("no shards"));
    scene.run_shard(0, 2);
    REQUIRE_THROWS_WITH(merge_shards(scene.dataset, scene.splits, {}, false), Contains("0001-of-0002.h5"));

    ShardedScene stiff;
    stiff.options.material.young_fat_pascal *= 3;
    stiff.dataset = scene.dataset;
    stiff.run_shard(1, 2);
    REQUIRE_THROWS_WITH(merge_shards(scene.dataset, scene.splits, {}, false), Contains("other options"));

    scene.run_shard(1, 3);
    REQUIRE_THROWS_WITH(merge_shards(scene.dataset, scene.splits, {}, false), Contains("of 2 and of 3"));
}

TEST_CASE("The status tells what is done, what runs and what is left")
{
    const ShardedScene scene;
    REQUIRE_THAT(status_report(dataset_status(scene.dataset, scene.splits, 3)),
                 Contains("0 of 4 done") && Contains("3 not started") && Contains("unfinished  0,1,2\n"));
    scene.run_shard(0, 3);  // two samples
    int asked = 0;
    const std::string second = shard_path(scene.dataset, Shard{1, 3});
    REQUIRE_THROWS_AS(scene.run(Shard{1, 3}, second, [&] { return ++asked > 0; }), Interrupted);
    REQUIRE_THAT(status_report(dataset_status(scene.dataset, scene.splits, 0)),
                 Contains("2 of 4 done") && Contains("1 complete") && Contains("1 stopped") &&
                     Contains("unfinished  1,2\n") && Contains("nothing is running"));
    {
        const PartFolder at_work(second, "key", scene.tube.num_volume_vertices(), true);
        const std::vector<ShardStatus> shards = dataset_status(scene.dataset, scene.splits, 0);
        REQUIRE(shards[1].state == ShardStatus::running);
        REQUIRE(shards[1].process.find(std::to_string(::getpid())) != std::string::npos);
        REQUIRE_THROWS_WITH(scene.run(Shard{1, 3}, second), Contains("already"));
    }
    REQUIRE_THROWS_AS(dataset_status(scene.dataset, scene.splits, 4), InputError);
    scene.run(
        Shard{1, 3}, second, [] { return false; }, true);
    scene.run_shard(2, 3);
    REQUIRE_THAT(status_report(dataset_status(scene.dataset, scene.splits, 0)),
                 Contains("4 of 4 done") && Contains("unfinished  none\n"));
}

TEST_CASE("The check names each defect")
{
    const ShardedScene scene;
    scene.run_shards(2);
    merge_shards(scene.dataset, scene.splits, {}, false);
    const auto defects = [&](const std::string& path) {
        std::string all;
        for (const std::string& sentence : check_dataset(path, scene.splits)) all += sentence + "\n";
        return all;
    };

    SECTION("a shard that was damaged")
    {
        scene.overwrite_middle(shard_path(scene.dataset, Shard{1, 2}));
        REQUIRE_THAT(defects(scene.dataset), Contains("0001-of-0002.h5 is not the file that was merged"));
    }
    SECTION("a shard that is gone")
    {
        fs::remove(shard_path(scene.dataset, Shard{0, 2}));
        REQUIRE_THAT(defects(scene.dataset), Contains("0000-of-0002.h5, which does not exist"));
        REQUIRE_THROWS_AS(open_deformations(scene.dataset), InputError);
    }
    SECTION("a shard of other options")
    {
        SampleScene stiff;
        stiff.options.material.young_fat_pascal *= 3;
        stiff.run(
            Shard{0, 2}, shard_path(scene.dataset, Shard{0, 2}), [] { return false; }, true);
        REQUIRE_THAT(defects(scene.dataset), Contains("0000-of-0002.h5 was made") && Contains("other options"));
    }
    SECTION("pairs that are missing, foreign or doubled, and vertices that stand twice")
    {
        DeformationSet set = in_memory(scene.dataset);
        set.pairs[1] = {1, 2};
        set.pairs[2] = set.pairs[0];
        set.vertices[2] = set.vertices[0];
        const std::string path = scene.folder.file("wrong.h5");
        write_deformations(path, set, {});
        const std::string text = defects(path);
        REQUIRE_THAT(text, Contains("body 0 in pose 0 of split train stands in it twice"));
        REQUIRE_THAT(text, Contains("body 0 in pose 1 of split train is missing, and 1 more like it"));
        REQUIRE_THAT(text, Contains("body 1 in pose 2 of split train is no pair of the splits"));
        REQUIRE_THAT(text, Contains("has the same vertices as body 0 in pose 0"));
    }
    SECTION("statistics that are missing")
    {
        DeformationSet set = in_memory(scene.dataset);
        set.statistics.erase("energy_joule");
        const std::string path = scene.folder.file("few.h5");
        write_deformations(path, set, {});
        REQUIRE_THAT(defects(path), Contains("statistic energy_joule is missing"));
    }
}

TEST_CASE("A sample that fails is stored with its reason, and the others without it")
{
    ShardedScene scene;
    scene.bodies.bodies[1].volume_vertices.setZero();  // no solver can stand this
    const DeformationSet whole = scene.run(Shard{}, scene.output);
    REQUIRE(whole.size() == 3);
    REQUIRE(whole.failures.size() == 1);
    REQUIRE(whole.failures[0].pair.body_idx == 1);
    REQUIRE(whole.failures[0].pair.pose_idx == 3);
    REQUIRE(whole.failures[0].split == "test");
    REQUIRE_FALSE(whole.failures[0].reason.empty());
    const SimulationSummary summary = summarize_simulation(whole);
    REQUIRE(summary.failed == 1);
    REQUIRE(summary.converged_share == 0.75);
    REQUIRE_THROWS_AS(require_converged(summary, 0.8), QualityError);
    REQUIRE(check_dataset(scene.output, scene.splits).empty());

    // The same through shards, and by an interrupted run.
    int asked = 0;
    const std::string last = shard_path(scene.dataset, Shard{1, 2});
    REQUIRE_THROWS_AS(scene.run(Shard{1, 2}, last, [&] { return ++asked > 1; }), Interrupted);
    scene.run_shards(2);
    const DeformationSet merged = merge_shards(scene.dataset, scene.splits, {}, false);
    require_same_samples(merged, whole);
    REQUIRE(merged.failures.size() == 1);
    REQUIRE(merged.failures[0].reason == whole.failures[0].reason);

    const Replay replay = replay_sample(scene.tube, scene.bodies, scene.poses, scene.splits, 3, scene.options);
    REQUIRE(replay.failure == whole.failures[0].reason);
    REQUIRE_THAT(replay_report(replay), Contains(replay.failure));
}

TEST_CASE("A replayed sample is the stored one, and its energy falls")
{
    const ShardedScene scene;
    scene.run(Shard{}, scene.output);
    const Replay replay = replay_sample(scene.tube, scene.bodies, scene.poses, scene.splits, 2, scene.options);
    REQUIRE(replay.task.pair.pose_idx == 2);
    REQUIRE_THAT(compare_with_stored(replay, scene.output), Contains("bit for bit"));
    REQUIRE_THAT(replay_report(replay), Contains("converged"));
    const std::vector<NewtonIteration>& history = replay.result.newton.history;
    REQUIRE(history.size() > 1);
    double energy = replay.result.newton.start_energy_joule;
    for (const NewtonIteration& iteration : history) {
        REQUIRE(iteration.energy_joule <= energy);
        energy = iteration.energy_joule;
    }

    const std::string path = scene.folder.file("replay.h5");
    write_replay(path, replay, {});
    const DeformationSet shown = open_deformations(path);
    REQUIRE(shown.size() == 2);
    REQUIRE((shown.points(0) - replay.start).cwiseAbs().maxCoeff() < 1e-6);
    REQUIRE((shown.points(1) - replay.result.vertices).cwiseAbs().maxCoeff() < 1e-6);

    SimulationOptions stiff = scene.options;
    stiff.material.young_fat_pascal *= 3;
    REQUIRE_THAT(
        compare_with_stored(replay_sample(scene.tube, scene.bodies, scene.poses, scene.splits, 2, stiff), scene.output),
        Contains("other vertices"));
    REQUIRE_THROWS_AS(replay_sample(scene.tube, scene.bodies, scene.poses, scene.splits, 4, scene.options), InputError);
}
