// SPDX-License-Identifier: Apache-2.0
// Clinical angles and motions written by hand.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/joint_limits.h"
#include "ndg/motion/keyframes.h"
#include "ndg/motion/motion_files.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <limits>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

using Angles = std::map<std::string, double>;

std::vector<double> radians(const Angles& degrees)
{
    std::vector<double> result(clinical_angle_names().size(), 0.0);
    for (const auto& [name, value] : degrees) {
        const int idx = find_clinical_angle(name);
        INFO(name);
        REQUIRE(idx >= 0);
        result[std::size_t(idx)] = value * degree;
    }
    return result;
}

/// Posed joint positions of a body.
class Posed {
public:
    explicit Posed(const Angles& degrees) : joints_(human_joints())
    {
        const Pose pose = ClinicalFrames(joints_).pose(radians(degrees));
        joints_ = posed_joints(joints_, pose);
    }
    Eigen::Vector3d at(const std::string& name) const
    {
        return joints_.row(standard_skeleton().joint(name)).transpose();
    }
    Eigen::Vector3d direction(const std::string& from, const std::string& to) const
    {
        return (at(to) - at(from)).normalized();
    }

private:
    Points joints_;
};

void check_near(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance)
{
    INFO(a.transpose() << " instead of " << b.transpose());
    CHECK((a - b).norm() < tolerance);
}

std::string motion_text(const std::string& rest)
{
    const std::string duration = rest.find("\"duration\"") == std::string::npos ? R"("duration": 2, )" : "";
    return R"({"format": "ndg-keyframes", "licence": "Apache-2.0", "frame_rate": 10, )" + duration + rest + "}";
}

KeyframeMotion motion_of(const std::string& rest)
{
    const test::TemporaryFolder folder;
    write_file(folder.file("m.json"), motion_text(rest));
    return read_keyframe_motion(folder.file("m.json"));
}

}  // namespace

TEST_CASE("the neutral posture stands with hanging arms, palms towards the thighs")
{
    const Posed neutral((Angles()));
    for (const std::string side : {"left_", "right_"}) {
        const double outward = side == "left_" ? 1.0 : -1.0;
        check_near(neutral.direction(side + "upper_arm", side + "forearm"), {0, -1, 0}, 1e-9);
        check_near(neutral.direction(side + "forearm", side + "hand"), {0, -1, 0}, 1e-9);
        check_near(neutral.direction(side + "hand", side + "middle_1"), {0, -1, 0}, 1e-9);
        check_near(neutral.direction(side + "thigh", side + "shin"), {0, -1, 0}, 1e-9);
        check_near(neutral.direction(side + "shin", side + "foot"), {0, -1, 0}, 1e-9);
        CHECK(neutral.at(side + "index_1").z() > neutral.at(side + "pinky_1").z() + 0.02);
        CHECK(neutral.at(side + "index_1").x() == Approx(neutral.at(side + "pinky_1").x()).margin(1e-9));
        CHECK(outward * neutral.at(side + "hand").x() > 0.1);
    }
}

TEST_CASE("clinical angles turn limbs the way their names say, left and right alike")
{
    for (const std::string side : {"left_", "right_"}) {
        INFO(side);
        const double out = side == "left_" ? 1.0 : -1.0;
        const auto arm = [&](const Angles& a) { return Posed(a).direction(side + "upper_arm", side + "forearm"); };
        const auto forearm = [&](const Angles& a) { return Posed(a).direction(side + "forearm", side + "hand"); };
        const auto thigh = [&](const Angles& a) { return Posed(a).direction(side + "thigh", side + "shin"); };
        const auto shin = [&](const Angles& a) { return Posed(a).direction(side + "shin", side + "foot"); };
        check_near(arm({{side + "shoulder.elevation", 90}}), {out, 0, 0}, 1e-9);
        check_near(arm({{side + "shoulder.elevation", 90}, {side + "shoulder.plane", 90}}), {0, 0, 1}, 1e-9);
        check_near(arm({{side + "shoulder.elevation", 180}, {side + "shoulder.plane", 40}}), {0, 1, 0}, 1e-9);
        check_near(arm({{side + "shoulder.elevation", 45}, {side + "shoulder.plane", -90}}),
                   {0, -std::sqrt(0.5), -std::sqrt(0.5)}, 1e-9);
        check_near(forearm({{side + "elbow.flexion", 90}}), {0, 0, 1}, 1e-9);
        check_near(forearm({{side + "elbow.flexion", 90}, {side + "shoulder.internal_rotation", 90}}), {-out, 0, 0},
                   1e-9);
        // A raised arm turned outwards points the bent forearm up.
        const Angles cactus = {{side + "shoulder.elevation", 90},
                               {side + "shoulder.internal_rotation", -90},
                               {side + "elbow.flexion", 90}};
        check_near(forearm(cactus), {0, 1, 0}, 1e-9);
        check_near(thigh({{side + "hip.flexion", 90}}), {0, 0, 1}, 1e-9);
        check_near(thigh({{side + "hip.abduction", 30}}), {out * 0.5, -std::sqrt(0.75), 0}, 1e-9);
        check_near(shin({{side + "knee.flexion", 90}}), {0, 0, -1}, 1e-9);
        // Turning the bent hip inwards swings the shin outwards.
        CHECK(out *
                  shin({{side + "hip.flexion", 90}, {side + "knee.flexion", 90}, {side + "hip.internal_rotation", 30}})
                      .x() ==
              Approx(0.5));
        const Posed rest((Angles()));
        const double toes = rest.at(side + "toes").y();
        CHECK(Posed({{side + "ankle.dorsiflexion", 20}}).at(side + "toes").y() > toes + 0.02);
        // Palms down with the elbow bent: the thumb side turns inwards.
        const Posed pronated({{side + "elbow.flexion", 90}, {side + "forearm.pronation", 90}});
        CHECK(out * (pronated.at(side + "index_1") - pronated.at(side + "pinky_1")).x() < -0.02);
        CHECK(Posed({{side + "elbow.flexion", 90}, {side + "wrist.radial_deviation", 20}}).at(side + "middle_1").y() >
              Posed({{side + "elbow.flexion", 90}}).at(side + "middle_1").y() + 0.01);
        // Towards the palm is towards the thigh.
        for (const std::string angle : {"wrist.flexion", "index_1.flexion", "pinky_2.flexion"}) {
            INFO(angle);
            const std::string finger = angle.substr(0, 5) == "pinky" ? "pinky_3" : "index_2";
            CHECK(out * (Posed({{side + angle, 60}}).at(side + finger) - rest.at(side + finger)).x() < -0.01);
        }
        CHECK(Posed({{side + "clavicle.elevation", 20}}).at(side + "upper_arm").y() > rest.at(side + "upper_arm").y());
        CHECK(Posed({{side + "clavicle.protraction", 20}}).at(side + "upper_arm").z() >
              rest.at(side + "upper_arm").z() + 0.01);
    }
    const Posed rest((Angles()));
    CHECK(Posed({{"trunk.flexion", 40}}).at("head").z() > rest.at("head").z() + 0.1);
    CHECK(Posed({{"trunk.bend_left", 30}}).at("head").x() > 0.1);
    CHECK(Posed({{"trunk.turn_left", 40}}).at("left_upper_arm").z() < rest.at("left_upper_arm").z() - 0.05);
    CHECK(Posed({{"neck.turn_left", 60}}).at("left_eye").z() < rest.at("left_eye").z());
    CHECK(Posed({{"neck.bend_left", 30}}).at("head").x() > 0.01);
    CHECK(Posed({{"jaw.opening", 20}}).at("head").y() == rest.at("head").y());
    check_near(Posed({{"pelvis.turn_left", 90}, {"pelvis.tilt_forward", 90}}).direction("pelvis", "head"), {1, 0, 0},
               0.02);
}

TEST_CASE("clinical angles are recovered from poses")
{
    const ClinicalFrames frames(human_joints());
    for (std::size_t k = 0; k < clinical_angle_names().size(); ++k) {
        const std::string& name = clinical_angle_names()[k];
        INFO(name);
        std::vector<double> angles(clinical_angle_names().size(), 0.0);
        angles[k] = 35 * degree;
        // The plane of a hanging arm has no meaning.
        if (name.find(".plane") != std::string::npos) {
            angles[std::size_t(find_clinical_angle(name.substr(0, name.find('.')) + ".elevation"))] = 80 * degree;
        }
        const std::vector<double> found = frames.angles(frames.pose(angles));
        for (std::size_t i = 0; i < angles.size(); ++i) {
            INFO(clinical_angle_names()[i]);
            CHECK(found[i] == Approx(angles[i]).margin(1e-9));
        }
    }
    // Three angles of one joint at once.
    const Angles mixed = {{"left_hip.flexion", 100},           {"left_hip.abduction", 30},
                          {"left_hip.internal_rotation", -25}, {"left_knee.flexion", 120},
                          {"right_wrist.flexion", 50},         {"right_wrist.radial_deviation", -20},
                          {"right_forearm.pronation", 70},     {"right_shoulder.elevation", 120},
                          {"right_shoulder.plane", 30},        {"right_shoulder.internal_rotation", -60},
                          {"right_clavicle.elevation", 15},    {"left_ankle.dorsiflexion", -30},
                          {"left_ankle.inversion", 20},        {"pelvis.turn_left", 120},
                          {"pelvis.tilt_forward", 30},         {"pelvis.lean_left", -20}};
    const std::vector<double> angles = radians(mixed), found = frames.angles(frames.pose(angles));
    for (std::size_t i = 0; i < angles.size(); ++i) {
        INFO(clinical_angle_names()[i]);
        CHECK(found[i] == Approx(angles[i]).margin(1e-9));
    }
}

TEST_CASE("angles mean the same on a body that rests in another pose")
{
    // The same body with spread, turned and bent arms and bent fingers as its rest.
    const Points spread = posed_joints(human_joints(), ClinicalFrames(human_joints())
                                                           .pose(radians({{"left_shoulder.elevation", 85},
                                                                          {"right_shoulder.elevation", 70},
                                                                          {"right_shoulder.plane", 10},
                                                                          {"left_elbow.flexion", 15},
                                                                          {"right_forearm.pronation", 25},
                                                                          {"left_index_1.flexion", 25},
                                                                          {"left_hip.abduction", 10}})));
    const std::vector<double> angles = radians({{"left_shoulder.elevation", 60},
                                                {"left_shoulder.plane", 40},
                                                {"left_shoulder.internal_rotation", 30},
                                                {"left_elbow.flexion", 70},
                                                {"right_shoulder.elevation", 100},
                                                {"right_elbow.flexion", 40},
                                                {"right_forearm.pronation", 50},
                                                {"left_wrist.flexion", 20},
                                                {"left_index_1.flexion", 40},
                                                {"left_hip.flexion", 50},
                                                {"left_knee.flexion", 80}});
    const Points a = posed_joints(human_joints(), ClinicalFrames(human_joints()).pose(angles));
    const Points b = posed_joints(spread, ClinicalFrames(spread).pose(angles));
    const Skeleton& skeleton = standard_skeleton();
    for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{{"left_upper_arm", "left_forearm"},
                                                                                   {"left_forearm", "left_hand"},
                                                                                   {"left_hand", "left_middle_1"},
                                                                                   {"left_index_1", "left_index_2"},
                                                                                   {"left_pinky_1", "left_index_1"},
                                                                                   {"right_upper_arm", "right_forearm"},
                                                                                   {"right_forearm", "right_hand"},
                                                                                   {"right_pinky_1", "right_index_1"},
                                                                                   {"left_thigh", "left_shin"},
                                                                                   {"left_shin", "left_foot"}}) {
        INFO(from);
        const Eigen::RowVector3d u = (a.row(skeleton.joint(to)) - a.row(skeleton.joint(from))).normalized();
        const Eigen::RowVector3d v = (b.row(skeleton.joint(to)) - b.row(skeleton.joint(from))).normalized();
        CHECK(std::acos(std::min(1.0, u.dot(v))) < 2 * degree);
    }
}

TEST_CASE("keys are met, not overshot, and periodic motions join smoothly")
{
    const KeyframeMotion motion = motion_of(
        R"("tracks": {"left_knee.flexion": [[0.5, 10], [1, 60], [1.2, 60], [2, 0]]}, "stance": {"jaw.opening": 5})");
    const auto knee = [&](const KeyframeMotion& m, double t) {
        return m.angles(t)[std::size_t(find_clinical_angle("left_knee.flexion"))] / degree;
    };
    CHECK(motion.num_frames() == 21);
    CHECK(knee(motion, 0) == Approx(10));
    CHECK(knee(motion, 1) == Approx(60));
    CHECK(knee(motion, 1.1) == Approx(60));
    CHECK(knee(motion, 2) == Approx(0).margin(1e-12));
    double previous = 10;
    for (double t = 0.5; t <= 1.0; t += 0.01) {
        CHECK(knee(motion, t) >= previous - 1e-9);
        CHECK(knee(motion, t) <= 60 + 1e-9);
        previous = knee(motion, t);
    }
    CHECK(motion.angles(0.3)[std::size_t(find_clinical_angle("jaw.opening"))] == Approx(5 * degree));

    const KeyframeMotion gait = motion_of(
        R"("period": 0.8, "tracks": {"alternating_knee.flexion": [[0, 5], [0.2, 20], [0.35, 8], [0.6, 60]]})");
    const int left = find_clinical_angle("left_knee.flexion"), right = find_clinical_angle("right_knee.flexion");
    for (double t = 0; t < 0.8; t += 0.05) {
        CHECK(gait.angles(t)[std::size_t(left)] == Approx(gait.angles(t + 0.4)[std::size_t(right)]).margin(1e-12));
        CHECK(gait.angles(t)[std::size_t(left)] == Approx(gait.angles(t + 0.8)[std::size_t(left)]).margin(1e-12));
    }
    const double h = 1e-5;
    const double before = (knee(gait, 0.8) - knee(gait, 0.8 - h)) / h,
                 after = (knee(gait, 0.8 + h) - knee(gait, 0.8)) / h;
    CHECK(before == Approx(after).margin(0.5));
}

TEST_CASE("poses of a motion name what they change and fall back on the stance")
{
    const KeyframeMotion motion = motion_of(
        R"("stance": {"both_elbow.flexion": 10}, "poses": [{"time": 0, "angles": {}},
           {"time": 1, "angles": {"left_elbow.flexion": 90, "both_fingers.curl": 50}}, {"time": 2, "angles": {}}])");
    const auto value = [&](const std::string& name, double t) {
        return motion.angles(t)[std::size_t(find_clinical_angle(name))] / degree;
    };
    CHECK(value("left_elbow.flexion", 0) == Approx(10));
    CHECK(value("left_elbow.flexion", 1) == Approx(90));
    CHECK(value("left_elbow.flexion", 2) == Approx(10));
    CHECK(value("right_elbow.flexion", 1) == Approx(10));
    CHECK(value("right_ring_2.flexion", 1) == Approx(50));
    CHECK(value("left_index_1.flexion", 1) == Approx(45));
}

TEST_CASE("malformed motions are refused in one sentence")
{
    const auto refused = [](const std::string& rest, const std::string& part) {
        INFO(rest);
        CHECK_THROWS_AS(motion_of(rest), InputError);
        CHECK_THROWS_WITH(motion_of(rest), Contains(part) && Contains("m.json"));
    };
    refused(R"("tracks": {"left_tail.flexion": [[0, 1]]})", "unknown angle \"left_tail.flexion\"");
    refused(R"("tracks": {"both_tail.flexion": [[0, 1]]})", "unknown angle \"both_tail.flexion\"");
    refused(R"("tracks": {"jaw.opening": [[1, 1], [0.5, 2]]})", "time 0.5 does not come after 1");
    refused(R"("tracks": {"jaw.opening": [[0, 1], [0, 2]]})", "time 0 does not come after 0");
    refused(R"("tracks": {"jaw.opening": [[0, 1], [2.5, 2]]})", "time 2.5 lies outside 0 to 2");
    refused(R"("period": 1, "tracks": {"jaw.opening": [[0, 1], [1, 2]]})", "time 1 lies outside 0 to 1");
    refused(R"("tracks": {"jaw.opening": [[0, null]]})", "tracks.jaw.opening[0][1]: expected a number, got null");
    refused(R"("tracks": {"jaw.opening": [[0, NaN]]})", "not valid JSON");
    refused(R"("tracks": {"jaw.opening": [[0, 1e999]]})", "not valid JSON");
    refused(R"("tracks": {"jaw.opening": [[0]]})", "tracks.jaw.opening[0]: expected [time, degrees], got [0]");
    refused(R"("tracks": {"jaw.opening": []})", "tracks.jaw.opening: expected a list of keys, got []");
    refused(R"("tracks": {"both_knee.flexion": [[0, 1]], "left_knee.flexion": [[0, 1]]})", "has two tracks");
    refused(R"("tracks": {"jaw.opening": [[0, 1]]}, "poses": [{"time": 0, "angles": {"jaw.opening": 1}}])",
            "has a track and a pose");
    refused(R"("poses": [{"time": 0, "angles": {"both_knee.flexion": 1, "left_knee.flexion": 2}}])", "is given twice");
    refused(R"("tracks": {"alternating_knee.flexion": [[0, 1]]})", "needs a \"period\"");
    refused(R"("ground": "moon", "tracks": {"jaw.opening": [[0, 1]]})",
            "ground: expected one of none | lowest_foot | both_feet, got \"moon\"");
    refused(R"("speed": 2, "tracks": {"jaw.opening": [[0, 1]]})", "unknown key \"speed\"");
    refused(R"("description": "nothing")", "neither tracks nor poses");
    refused(R"("duration": -1, "tracks": {"jaw.opening": [[0, 1]]})",
            "duration: expected a number in (0, 3600], got -1");
    const test::TemporaryFolder folder;
    write_file(folder.file("m.json"), "{\"format\": \"ndg-keyframes\", \"tracks\": {");
    CHECK(is_keyframe_motion(folder.file("m.json")));
    CHECK_THROWS_WITH(read_keyframe_motion(folder.file("m.json")), Contains("not valid JSON"));
    write_file(folder.file("other.json"), "{\"Frames\": []}");
    CHECK_FALSE(is_keyframe_motion(folder.file("other.json")));
    CHECK_THROWS_WITH(read_keyframe_motion(folder.file("none.json")), Contains("none.json: does not exist"));
}
