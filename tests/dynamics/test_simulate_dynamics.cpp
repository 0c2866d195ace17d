// SPDX-License-Identifier: Apache-2.0
// Motions as a batch: broken off, resumed, refused.
#include "soft_shapes.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/dynamics/scene_file.h"
#include "ndg/dynamics/simulate_dynamics.h"
#include "ndg/io/h5.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;

namespace {

PoseSet clips(int num_clips)
{
    PoseSet set;
    for (int c = 0; c < num_clips; ++c) {
        set.clip_names.push_back("bend " + std::to_string(c));
        set.clip_frame_rates.push_back(30);
        for (int n = 0; n < 16; ++n) {
            set.poses.push_back(test::tube_pose(0.05 * (c + 1) * n));
            set.clip_idx.push_back(c);
            set.frame_idx.push_back(n);
        }
    }
    return set;
}

DynamicsRun tube_run(const Template& tube)
{
    DynamicsRun run;
    run.model = "soft-tissue";
    run.options.frames_per_block = 3;
    run.options_key = "tube";
    run.make_actor = [&tube] {
        DynamicActor actor;
        actor.body = std::make_unique<SoftTissueBody>(test::soft_tube(tube, 8e3, 15e3), test::tube_poser(tube),
                                                      TissueOptions{}, 1000);
        return actor;
    };
    return run;
}

bool never()
{
    return false;
}

}  // namespace

TEST_CASE("A run that is broken off after any block goes on to the same bits")
{
    const test::TemporaryFolder folder;
    const Template tube = test::tube_template(7, 8);
    const DynamicsRun run = tube_run(tube);
    const std::vector<DynamicSequence> sequences = sequences_of(clips(2), {}, run.options.step_rate_hertz);
    REQUIRE(sequences.size() == 2);
    REQUIRE(sequences[0].poses.size() == 61);
    const DynamicsSet whole = simulate_dynamics(run, sequences, folder.file("whole.h5"), {}, never);
    REQUIRE(whole.num_frames() == 32);
    REQUIRE(whole.statistics.at("converged") == std::vector<double>(32, 1.0));
    REQUIRE(whole.frames_of(1) == std::pair(16, 32));

    const std::string output = folder.file("resumed.h5");
    int interruptions = 0;
    for (int asked = 0; !std::filesystem::exists(output); asked = 0) {
        try {
            // Also what a kill in the middle of writing leaves.
            simulate_dynamics(run, sequences, output, {}, [&] { return asked++ >= 5; });
        } catch (const Interrupted&) {
            ++interruptions;
            write_file(output + ".parts/motion-00001-block-00009.h5.123.tmp", "half");
            if (interruptions == 2) write_file(output + ".parts/motion-00000-block-00001.h5", "damaged");
        }
        REQUIRE(interruptions < 30);
    }
    REQUIRE(interruptions >= 2);
    REQUIRE(!std::filesystem::exists(output + ".parts"));
    const DynamicsReader a(folder.file("whole.h5")), b(output);
    REQUIRE(a.set().times == b.set().times);
    double moved = 0;
    for (int f = 0; f < 32; ++f) {
        REQUIRE(a.frame(f) == b.frame(f));
        moved = std::max(moved, (a.frame(f) - a.set().rest).norm());
    }
    REQUIRE(moved > 0.1);
    for (const char* name : {"iterations", "factorizations", "residual_relative", "potential_energy_joule"}) {
        REQUIRE(a.set().statistics.at(name) == b.set().statistics.at(name));
    }
    check_h5(output);

    // Once more: nothing to do. Other options: refused, unless forced.
    const auto written = std::filesystem::last_write_time(output);
    simulate_dynamics(run, sequences, output, {}, never);
    REQUIRE(std::filesystem::last_write_time(output) == written);
    DynamicsRun other = run;
    other.options_key = "other";
    REQUIRE_THROWS_AS(simulate_dynamics(other, sequences, output, {}, never), InputError);
    REQUIRE_NOTHROW(simulate_dynamics(other, {sequences[0]}, output, {}, never, true));
    REQUIRE(DynamicsReader(output).set().num_frames() == 16);
    REQUIRE_THROWS_AS(DynamicsReader(output).frame(16), InputError);
}

TEST_CASE("A motion that cannot go on fails alone, and says why")
{
    const test::TemporaryFolder folder;
    const Template tube = test::tube_template(7, 8);
    const DynamicsRun run = tube_run(tube);
    PoseSet poses = clips(2);
    // Turned by half a turn about its axis, blended skinning collapses at the elbow.
    for (int n = 8; n < 16; ++n) {
        poses.poses[static_cast<std::size_t>(n)]
            .parent_from_joint[static_cast<std::size_t>(tube.skeleton.joint("left_forearm"))] =
            Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix();
    }
    const std::vector<DynamicSequence> sequences = sequences_of(poses, {}, run.options.step_rate_hertz);
    const DynamicsSet set = simulate_dynamics(run, sequences, folder.file("out.h5"), {}, never);
    REQUIRE(set.sequence_names == std::vector<std::string>{"bend 1"});
    REQUIRE(set.num_frames() == 16);
    REQUIRE(set.failed_sequences == std::vector<std::string>{"bend 0"});
    REQUIRE_THAT(set.failure_reasons[0], Catch::Contains("skinning squeezes space at vertex"));
    REQUIRE_THROWS_AS(require_converged(set, 0), QualityError);
    REQUIRE_THAT(dynamics_report(set), Catch::Contains("1 failed"));
}

TEST_CASE("Clips become motions at the step rate; shards part them")
{
    PoseSet poses = clips(3);
    REQUIRE(sequences_of(poses, {"bend 1"}, 60).size() == 1);
    REQUIRE(sequences_of(poses, {"bend 1"}, 60)[0].poses.size() == 31);
    REQUIRE_THROWS_AS(sequences_of(poses, {"jump"}, 60), InputError);
    const std::vector<DynamicSequence> all = sequences_of(poses, {}, 60);
    REQUIRE(shard_of(all, {1, 2}).size() == 1);
    REQUIRE(shard_of(all, {1, 2})[0].name == "bend 1");
    REQUIRE(shard_of(all, {0, 2}).size() == 2);
    REQUIRE_THROWS_AS(shard_of(all, {3, 4}), InputError);
    poses.frame_idx[5] = 3;
    REQUIRE_THROWS_WITH(sequences_of(poses, {}, 60), Catch::Contains("no motion"));
    REQUIRE_THROWS_AS(sequences_of(PoseSet(), {}, 60), InputError);
}

TEST_CASE("Scenes are read strictly")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("scene.json");
    const auto read = [&](const std::string& text) {
        write_file(path, text);
        return read_scene(path);
    };
    const Scene scene = read(R"({"gravity": true, "loads": [
        {"name": "bag", "joint": "left_hand", "radius_m": 0.1, "mass_kg": 2},
        {"name": "stone", "center": [0.1, 1, 0], "radius_m": 0.05, "mass_kg": 0.5, "from_s": 1.5}]})");
    REQUIRE(scene.loads.gravity);
    REQUIRE(scene.loads.loads.size() == 2);
    REQUIRE(scene.loads.loads[0].joint == "left_hand");
    REQUIRE(!scene.loads.loads[0].center);
    REQUIRE(scene.loads.loads[1].center->y() == 1);
    REQUIRE(scene.loads.loads[1].from_s == 1.5);
    REQUIRE(read("{}").loads.loads.empty());
    for (const char* wrong :
         {R"({"gravty": true})", R"({"loads": [{"name": "a", "radius_m": 1, "mass_kg": 1}]})",
          R"({"loads": [{"name": "a", "joint": "head", "center": [0, 0, 0], "radius_m": 1, "mass_kg": 1}]})",
          R"({"loads": [{"name": "a", "joint": "head", "radius_m": 0, "mass_kg": 1}]})",
          R"({"loads": [{"name": "a", "joint": "head", "radius_m": 1, "mass_kg": -1}]})",
          R"({"loads": [{"name": "a", "joint": "head", "radius_m": 1, "mass_kg": 1, "colour": "red"}]})",
          R"({"loads": [{"name": "a", "center": [0, 0], "radius_m": 1, "mass_kg": 1}]})", R"({"loads": 3})"}) {
        CAPTURE(wrong);
        REQUIRE_THROWS_AS(read(wrong), InputError);
    }
}
