// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/joint_flesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;

TEST_CASE("Flesh about a joint is what both its bones move, and its volume is told against rest")
{
    Template tube = test::tube_template();
    const int thigh = tube.skeleton.joint("left_thigh"), shin = tube.skeleton.joint("left_shin");
    const int upper_arm = tube.skeleton.joint("left_upper_arm"), forearm = tube.skeleton.joint("left_forearm");
    // The tube's elbow is made a knee; its own joints are none of those looked at.
    const Points& rest = tube.rest.volume_vertices;
    for (const double change : JointFlesh(tube).volume_changes(rest, 2 * rest)) CHECK(change == 0);
    auto& joints = tube.skin_weights.joints;
    for (Eigen::Index i = 0; i < joints.size(); ++i) {
        if (joints.data()[i] == upper_arm) joints.data()[i] = thigh;
        if (joints.data()[i] == forearm) joints.data()[i] = shin;
    }
    const JointFlesh flesh(tube);
    const auto& names = flesh_joint_names();
    REQUIRE(names.size() == 6);
    const auto knee = std::find(names.begin(), names.end(), "left_knee") - names.begin();
    const std::vector<int>& prisms = flesh.prisms()[knee];
    REQUIRE(!prisms.empty());
    REQUIRE(static_cast<int>(prisms.size()) < tube.num_prisms());
    for (std::size_t j = 0; j < names.size(); ++j) REQUIRE((int(j) == knee || flesh.prisms()[j].empty()));

    const Points grown = 1.1 * rest;
    const std::vector<double> changes = flesh.volume_changes(rest, grown);
    CHECK(changes[knee] == Approx(1.1 * 1.1 * 1.1 - 1));
    CHECK(changes[knee == 0 ? 1 : 0] == 0);
}
