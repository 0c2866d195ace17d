// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/motion/clinical_angles.h"
#include "ndg/motion/range_of_motion.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

/// Poses with one angle at 0, 1, ... `count` - 1 degrees.
PoseSet poses_of(const std::string& angle, int count, double step = 1.0)
{
    const ClinicalFrames frames(human_joints());
    PoseSet poses;
    poses.clip_names = {"clip"};
    poses.clip_frame_rates = {30.0};
    for (int i = 0; i < count; ++i) {
        std::vector<double> angles(clinical_angle_names().size(), 0.0);
        angles[std::size_t(find_clinical_angle(angle))] = i * step * degree;
        poses.poses.push_back(frames.pose(angles));
        poses.clip_idx.push_back(0);
        poses.frame_idx.push_back(i);
    }
    return poses;
}

const AngleRange& find(const RangeOfMotion& ranges, const std::string& angle)
{
    for (const AngleRange& range : ranges.angles) {
        if (range.angle == angle) return range;
    }
    throw Error("no such angle: " + angle);
}

JointLimitTable limits()
{
    return read_joint_limits(config_path("joint-limits.json"));
}

}  // namespace

TEST_CASE("extremes and percentiles of an angle are those it was made with")
{
    for (const std::string angle :
         {"left_knee.flexion", "right_hip.abduction", "trunk.turn_left", "right_thumb_2.flexion"}) {
        INFO(angle);
        const RangeOfMotion ranges = range_of_motion(poses_of(angle, 101, 0.4), human_joints(), nullptr);
        CHECK(ranges.num_poses == 101);
        CHECK(ranges.joints.empty());
        const AngleRange& range = find(ranges, angle);
        CHECK(range.min == Approx(0).margin(1e-9));
        CHECK(range.percentile_1 == Approx(0.4 * degree));
        CHECK(range.median == Approx(20 * degree));
        CHECK(range.percentile_99 == Approx(39.6 * degree));
        CHECK(range.max == Approx(40 * degree));
        CHECK_FALSE(range.has_limits);
        for (const AngleRange& other : ranges.angles) {
            if (other.angle != angle && other.angle.find("plane") == std::string::npos) {
                INFO(other.angle);
                CHECK(other.max == Approx(0).margin(1e-8));
            }
        }
    }
    CHECK_THROWS_AS(range_of_motion(PoseSet(), human_joints(), nullptr), InputError);
}

TEST_CASE("poses beyond published ranges are counted, left and right alike")
{
    const JointLimitTable table = limits();
    for (const std::string motion : {"knee.flexion", "hip.abduction", "ankle.inversion", "wrist.flexion",
                                     "elbow.flexion", "thumb_2.flexion", "thumb_1.abduction", "index_1.flexion"}) {
        for (const std::string side : {"left_", "right_"}) {
            const std::string angle = side + motion;
            INFO(angle);
            // Abduction and inversion come second in their joints, where 90 degrees are the end.
            const bool second =
                motion == "hip.abduction" || motion == "ankle.inversion" || motion == "thumb_1.abduction";
            const int count = second ? 89 : 151;
            const RangeOfMotion ranges = range_of_motion(poses_of(angle, count), human_joints(), &table);
            const AngleRange& range = find(ranges, angle);
            REQUIRE(range.has_limits);
            CHECK(range.low <= 0.0);
            CHECK(range.high > 10 * degree);
            CHECK(range.high < 155 * degree);
            int outside = 0;
            for (int i = 0; i < count; ++i) outside += i * degree > range.high + 0.5 * degree ? 1 : 0;
            CHECK(range.share_outside == Approx(outside / static_cast<double>(count)));
            // The limits' own measure finds the same border, at the joint that moves.
            double worst = 0.0;
            for (const JointExcess& joint : ranges.joints) {
                if (joint.worst > worst) worst = joint.worst;
            }
            CHECK(worst == Approx(std::max(0.0, (count - 1) * degree - range.high)).margin(1e-6));
            const AngleRange& left = find(ranges, "left_" + motion);
            CHECK(range.low == Approx(left.low).margin(1e-12));
            CHECK(range.high == Approx(left.high));
        }
    }
    // Of groups the joints' ranges add up.
    const RangeOfMotion turned = range_of_motion(poses_of("neck.turn_left", 10), human_joints(), &table);
    CHECK(find(turned, "neck.turn_left").high > 60 * degree);
    CHECK(find(turned, "neck.turn_left").share_outside == 0.0);
}

TEST_CASE("the table and the file hold every angle")
{
    const JointLimitTable table = limits();
    const RangeOfMotion ranges = range_of_motion(poses_of("left_knee.flexion", 176), human_joints(), &table);
    const std::string text = range_of_motion_table(ranges);
    CHECK_THAT(text, Contains("left_knee.flexion") && Contains("175.0") && Contains("left_shin: beyond its range in"));
    CHECK_THAT(text, !Contains("-0.0") && !Contains("right_shin: beyond") && !Contains("pelvis"));
    const nlohmann::json file = nlohmann::json::parse(range_of_motion_json(ranges));
    CHECK(file["angles"].size() == ranges.angles.size());
    CHECK(file["angles"]["left_knee.flexion"]["max"].get<double>() == Approx(175));
    CHECK(file["joints"]["left_shin"]["worst_pose"] == 175);
}
