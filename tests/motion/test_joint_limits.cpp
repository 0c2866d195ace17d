// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/clinical_angles.h"
#include "ndg/motion/joint_limits.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

const JointLimits& limits()
{
    static const JointLimits table(read_joint_limits(config_path("joint-limits.json")), human_joints());
    return table;
}

/// Pose of clinical angles in degrees.
std::vector<Eigen::Matrix3d> pose(const std::map<std::string, double>& angles)
{
    static const ClinicalFrames frames(human_joints());
    std::vector<double> values(clinical_angle_names().size(), 0.0);
    for (const auto& [name, angle] : angles) {
        const int idx = find_clinical_angle(name);
        REQUIRE(idx >= 0);
        values[std::size_t(idx)] = angle * degree;
    }
    return frames.pose(values).parent_from_joint;
}

/// Excess of a joint in degrees.
double excess(const std::map<std::string, double>& angles, const std::string& joint)
{
    return limits().excess(pose(angles))[standard_skeleton().joint(joint)] / degree;
}

double largest(const std::vector<double>& values)
{
    return *std::max_element(values.begin(), values.end());
}

std::vector<Eigen::Matrix3d> random_pose(Random& random, double size)
{
    std::vector<Eigen::Matrix3d> local(num_standard_joints);
    for (Eigen::Matrix3d& rotation : local) {
        rotation = rotation_of(size * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    }
    return local;
}

double largest_angle(const std::vector<Eigen::Matrix3d>& a, const std::vector<Eigen::Matrix3d>& b)
{
    double angle = 0.0;
    for (std::size_t j = 0; j < a.size(); ++j) angle = std::max(angle, rotation_angle(a[j], b[j]));
    return angle;
}

}  // namespace

TEST_CASE("the shipped limits cover every joint that motion moves, and give both sides the same")
{
    const JointLimitTable table = read_joint_limits(config_path("joint-limits.json"));
    std::vector<bool> covered(num_standard_joints, false);
    for (const JointRange& range : table.ranges) {
        CHECK_FALSE(covered[range.joint]);
        covered[range.joint] = true;
    }
    for (int j = 0; j < num_standard_joints; ++j) {
        INFO(standard_skeleton().joint_names[j]);
        CHECK(covered[j] == (j > 0));
    }
    // Sums over the joints of the spine: the segments of Pearcey et al. and of White and Panjabi, each once.
    double flexion = 0.0, turning = 0.0, neck = 0.0;
    for (const JointRange& range : table.ranges) {
        const std::string& name = standard_skeleton().joint_names[range.joint];
        if (name.rfind("spine_", 0) == 0) flexion += range.high[0] / degree;
        if (name.rfind("spine_", 0) == 0) turning += range.high[1] / degree;
        if (name.rfind("neck_", 0) == 0 || name == "head") neck += range.high[1] / degree;
    }
    CHECK(flexion == Approx(52.0 + 0.5 * 76.0));
    CHECK(turning == Approx(9.0 + 71.0));
    CHECK(neck == Approx(77.0));
}

TEST_CASE("postures of daily life are within the limits")
{
    CHECK(largest(limits().excess(pose({}))) < 1e-9);
    CHECK(largest(limits().excess(std::vector<Eigen::Matrix3d>(num_standard_joints, Eigen::Matrix3d::Identity()))) <
          1e-9);
    const std::map<std::string, double> sitting = {{"left_hip.flexion", 90},   {"right_hip.flexion", 90},
                                                   {"left_knee.flexion", 90},  {"right_knee.flexion", 90},
                                                   {"left_elbow.flexion", 90}, {"right_forearm.pronation", 60},
                                                   {"trunk.flexion", 20},      {"neck.turn_left", 40}};
    CHECK(largest(limits().excess(pose(sitting))) < 1e-9);
    for (const double plane : {0.0, 30.0, 60.0, 90.0}) {
        for (const double elevation : {0.0, 45.0, 90.0, 135.0, 170.0}) {
            CAPTURE(plane, elevation);
            CHECK(excess({{"left_shoulder.plane", plane}, {"left_shoulder.elevation", elevation}}, "left_upper_arm") <
                  1e-9);
            CHECK(excess({{"right_shoulder.plane", plane}, {"right_shoulder.elevation", elevation}},
                         "right_upper_arm") < 1e-9);
        }
    }
}

TEST_CASE("an angle beyond its published limit is counted by what it is beyond")
{
    struct Case {
        const char *angle, *joint;
        double limit;
        bool negative = false;
    };
    const std::vector<Case> cases = {{"left_knee.flexion", "left_shin", 142.5 + 2 * 5.4},
                                     {"right_knee.flexion", "right_shin", 142.5 + 2 * 5.4},
                                     {"right_knee.flexion", "right_shin", -1.6 + 2 * 2.9, true},
                                     {"left_hip.flexion", "left_thigh", 122.3 + 2 * 6.1},
                                     {"right_hip.flexion", "right_thigh", 9.8 + 2 * 6.8, true},
                                     {"right_hip.abduction", "right_thigh", 45.9 + 2 * 9.3},
                                     {"left_hip.abduction", "left_thigh", 26.9 + 2 * 4.1, true},
                                     {"right_hip.internal_rotation", "right_thigh", 47.3 + 2 * 6.0},
                                     {"left_hip.internal_rotation", "left_thigh", 47.2 + 2 * 6.3, true},
                                     {"left_ankle.dorsiflexion", "left_foot", 12.6 + 2 * 4.4},
                                     {"right_ankle.inversion", "right_foot", 36.8 + 2 * 4.5},
                                     {"left_ankle.inversion", "left_foot", 20.7 + 2 * 5.0, true},
                                     {"left_elbow.flexion", "left_forearm", 142.9 + 2 * 5.6},
                                     {"right_forearm.pronation", "right_hand", 75.8 + 2 * 5.1},
                                     {"left_forearm.pronation", "left_hand", 82.1 + 2 * 3.8, true},
                                     {"right_wrist.flexion", "right_hand", 76.4 + 2 * 6.3},
                                     {"left_wrist.radial_deviation", "left_hand", 21.5 + 2 * 4.0},
                                     {"left_clavicle.elevation", "left_clavicle", 41.8},
                                     {"right_clavicle.protraction", "right_clavicle", 41.8},
                                     {"left_toes.extension", "left_toes", 70.0},
                                     {"left_middle_2.flexion", "left_middle_2", 105.0},
                                     {"right_thumb_2.flexion", "right_thumb_2", 56.0},
                                     {"left_thumb_3.flexion", "left_thumb_3", 73.0},
                                     {"left_eye.up", "left_eye", 27.9 + 2 * 7.6}};
    for (const Case& c : cases) {
        INFO(c.angle);
        const double sign = c.negative ? -1.0 : 1.0;
        CHECK(excess({{c.angle, sign * (c.limit - 0.1)}}, c.joint) < 1e-6);
        CHECK(excess({{c.angle, sign * (c.limit + 7.0)}}, c.joint) == Approx(7.0).margin(1e-4));
    }
    // Within the wrist's range whatever the forearm is turned to, because deviation is counted in the turned axes.
    CHECK(excess({{"left_forearm.pronation", 80}, {"left_wrist.flexion", 85}}, "left_hand") < 1e-6);
    CHECK(excess({{"left_forearm.pronation", 80}, {"left_wrist.radial_deviation", 40}}, "left_hand") > 5.0);
}

TEST_CASE("a clamped pose is within the limits, and stays as it is if it was")
{
    Random random(3, "limits");
    for (int k = 0; k < 30; ++k) {
        const auto wild = random_pose(random, 0.2 + 0.05 * k);
        const auto clamped = limits().clamped(wild);
        CHECK(largest(limits().excess(clamped)) < 1e-7);
        CHECK(largest_angle(limits().clamped(clamped), clamped) < 1e-6);
        CHECK(rotation_angle(clamped[0], wild[0]) == 0.0);
        for (const Eigen::Matrix3d& rotation : clamped) {
            CHECK((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
        }
    }
    const auto sitting = pose({{"left_hip.flexion", 90}, {"left_knee.flexion", 90}, {"trunk.flexion", 20}});
    CHECK(largest_angle(limits().clamped(sitting), sitting) == 0.0);
    // A knee bent too far is bent as far as it goes.
    const auto bent = limits().clamped(pose({{"left_knee.flexion", 160}}));
    CHECK(largest_angle(bent, pose({{"left_knee.flexion", 142.5 + 2 * 5.4}})) < 1e-6);
    // The hand keeps its place where only the joint between forearm and hand is beyond its share.
    const auto twisted = pose({{"right_forearm.pronation", 60}});
    auto uneven = twisted;
    const int twist = standard_skeleton().joint("right_forearm_twist"), hand = standard_skeleton().joint("right_hand");
    uneven[twist] = twisted[twist] * twisted[hand];
    uneven[hand] = Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d before = uneven[twist] * uneven[hand];
    const auto clamped = limits().clamped(uneven);
    CHECK(rotation_angle(clamped[twist], uneven[twist]) > 1.0 * degree);
    CHECK(rotation_angle(clamped[twist] * clamped[hand], before) < 1e-9);
}

TEST_CASE("clamping is continuous, through half turns too")
{
    Random random(4, "limits");
    for (int path = 0; path < 4; ++path) {
        // Whole turns of all joints about axes of their own, from a pose far outside the limits.
        std::vector<Eigen::Vector3d> axes(num_standard_joints);
        for (Eigen::Vector3d& v : axes) {
            v = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
        }
        const auto start = random_pose(random, 1.0);
        const auto clamped_at = [&](double turn) {
            auto local = start;
            for (std::size_t j = 0; j < local.size(); ++j) local[j] = rotation_of(turn * axes[j]) * start[j];
            return limits().clamped(local);
        };
        // Where the result moves fastest, steps a hundred times smaller make its steps as much smaller.
        constexpr int count = 1500;
        constexpr double step = 2.0 * M_PI / count;
        double largest_step = 0.0, at = 0.0;
        auto last = clamped_at(0.0);
        for (int k = 1; k <= count; ++k) {
            const auto clamped = clamped_at(k * step);
            const double angle = largest_angle(clamped, last);
            if (angle > largest_step) at = (k - 1) * step;
            largest_step = std::max(largest_step, angle);
            last = clamped;
        }
        double largest_small_step = 0.0;
        last = clamped_at(at);
        for (int k = 1; k <= 100; ++k) {
            const auto clamped = clamped_at(at + 0.01 * k * step);
            largest_small_step = std::max(largest_small_step, largest_angle(clamped, last));
            last = clamped;
        }
        CAPTURE(path, largest_step / degree, largest_small_step / degree);
        CHECK(largest_step < 60.0 * degree);
        CHECK(largest_small_step < 0.1 * largest_step);
    }
}

TEST_CASE("files of joint limits are checked")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("limits.json");
    const auto check = [&](const std::string& joints, const std::string& message) {
        std::ofstream(path) << R"({"standard_deviations": 2, "unlisted_degrees": 10, "sources": {"a": "A 1999"}, )"
                            << "\"joints\": {" << joints << "}}";
        CHECK_THROWS_AS(read_joint_limits(path), InputError);
        CHECK_THROWS_WITH(read_joint_limits(path), Contains("limits.json") && Contains(message));
    };
    check(R"("tail": {"long_axis": "y"})", "\"tail\" is not one of our joints");
    check(R"("shin": {})", "joints.shin: has no \"long_axis\"");
    check(R"("shin": {"long_axis": "w"})", "joints.shin.long_axis: expected one of x | y | z, got \"w\"");
    check(R"("shin": {"long_axis": "y", "colour": 1})", "joints.shin: unknown key \"colour\", did you mean \"cone\"?");
    check(R"("pelvis": {"long_axis": "y"})", "the root \"pelvis\"");
    check(R"("shin": {"long_axis": "y", "base": "toes"})", "not a joint above it");
    check(R"("shin": {"long_axis": "y", "x": {"+": {"degrees": 20}}})", "joints.shin.x.+: has no \"source\"");
    check(R"("shin": {"long_axis": "y", "x": {"+": {"degrees": 20, "source": "b"}}})", "source \"b\"");
    check(R"("shin": {"long_axis": "y", "x": {"+": {"degrees": "x", "source": "a"}}})",
          "joints.shin.x.+.degrees: expected a number in [-180, 200], got \"x\"");
    check(R"("shin": {"long_axis": "y", "x": {"+": {"degrees": -20, "source": "a"}}})", "-10 to -20 degrees");
    check(R"("shin": {"long_axis": "y", "x": {"+": {"degrees": 170, "source": "a"}}})", "at most 160");
    std::ofstream(path) << "{";
    CHECK_THROWS_WITH(read_joint_limits(path), Contains("not valid JSON"));
    CHECK_THROWS_AS(read_joint_limits(folder.file("none.json")), InputError);
}
