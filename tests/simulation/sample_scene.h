// SPDX-License-Identifier: Apache-2.0
// What the tests of datasets share.
#pragma once

#include "bending_simulation.h"
#include "ndg/simulation/sample_part.h"
#include "ndg/simulation/simulate.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <functional>
#include <string>

namespace ndg::test {

/// Four samples of a small tube, three for training and one for testing.
struct SampleScene {
    Template tube = tube_template(5, 5);
    BodySet bodies;
    PoseSet poses;
    Splits splits;
    SimulationOptions options = test::bending_simulation();
    TemporaryFolder folder;
    std::string output = folder.file("samples.h5");

    SampleScene()
    {
        for (const double scale : {1.0, 1.2}) {
            Body body = tube.rest;
            for (Points* points :
                 {&body.volume_vertices, &body.skin_vertices, &body.interior_vertices, &body.joint_positions}) {
                *points *= scale;
            }
            bodies.bodies.push_back(body);
        }
        for (const double angle : {0.2, -0.4, 0.6, 0.8}) poses.poses.push_back(tube_pose(angle));
        splits.bodies = {{"train", {0}}, {"validation", {}}, {"test", {1}}};
        splits.poses = {{"train", {0, 1, 2}}, {"validation", {}}, {"test", {3}}};
        splits.pairs = {{"train", {{0, 0}, {0, 1}, {0, 2}}}, {"validation", {}}, {"test", {{1, 3}}}};
    }

    DeformationSet run(
        const Shard& shard, const std::string& path, const std::function<bool()>& stop = [] { return false; },
        bool force = false) const
    {
        return simulate_samples(tube, bodies, poses, sample_tasks(splits, shard), options, path, Provenance{}, stop,
                                force);
    }
};

/// All but the seconds.
inline void require_same_samples(const DeformationSet& a, const DeformationSet& b)
{
    REQUIRE(a.size() == b.size());
    for (int i = 0; i < a.size(); ++i) REQUIRE(a.coordinates(i) == b.coordinates(i));
    REQUIRE(a.pair_splits == b.pair_splits);
    for (std::size_t i = 0; i < a.pairs.size(); ++i) {
        REQUIRE(a.pairs[i].body_idx == b.pairs[i].body_idx);
        REQUIRE(a.pairs[i].pose_idx == b.pairs[i].pose_idx);
    }
    REQUIRE(a.stop_reasons == b.stop_reasons);
    for (const std::string& name : simulation_statistics()) {
        if (name != "seconds") REQUIRE(a.statistics.at(name) == b.statistics.at(name));
    }
}

}  // namespace ndg::test
