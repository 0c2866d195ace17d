// SPDX-License-Identifier: Apache-2.0
// Joint maps of known rigs, and proposals for unknown ones.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/joint_map_names.h"
#include "ndg/retarget/joint_map_proposal.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <map>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

/// A rig with joints at ours: rows of {name, parent, our joint at its place}. Children lie where the body has them;
/// tips at the mean of the children, leaves a little further.
using Rows = std::vector<std::array<std::string, 3>>;
MotionClip make_rig(const std::string& name, const Rows& rows)
{
    const Points joints = human_joints();
    MotionClip clip;
    clip.name = name;
    clip.zero_pose_positions.resize(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t j = 0; j < rows.size(); ++j) {
        clip.joint_names.push_back(rows[j][0]);
        clip.parents.push_back(rows[j][1].empty() ? -1 : clip.find_joint(rows[j][1]));
        clip.zero_pose_positions.row(static_cast<Eigen::Index>(j)) = joints.row(standard_skeleton().joint(rows[j][2]));
    }
    clip.zero_pose_positions.rowwise() -= clip.zero_pose_positions.row(0).eval();
    clip.zero_pose_tips = clip.zero_pose_positions;
    for (std::size_t j = 0; j < rows.size(); ++j) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        int count = 0;
        for (std::size_t c = j + 1; c < rows.size(); ++c) {
            if (clip.parents[c] != static_cast<int>(j)) continue;
            sum += clip.zero_pose_positions.row(static_cast<Eigen::Index>(c));
            ++count;
        }
        const auto row = static_cast<Eigen::Index>(j);
        if (count > 0) clip.zero_pose_tips.row(row) = sum / count;
        if (count > 0) continue;
        // Hands go on as the forearm does.
        const int parent = clip.parents[j];
        const Eigen::RowVector3d before = clip.zero_pose_positions.row(row) - clip.zero_pose_positions.row(parent);
        clip.zero_pose_tips.row(row) += rows[j][2].find("hand") != std::string::npos
                                            ? Eigen::RowVector3d(0.3 * before)
                                            : Eigen::RowVector3d(0, rows[j][2] == "head" ? 0.2 : 0, 0.04);
    }
    clip.frame_rate = 30;
    clip.root_positions = Points::Zero(1, 3);
    clip.world_from_joint.assign(1, std::vector<Eigen::Matrix3d>(rows.size(), Eigen::Matrix3d::Identity()));
    return clip;
}

/// Both sides of a limb; % stands for what names the side.
void add_limbs(Rows& rows, const Rows& limbs, const std::string& left, const std::string& right)
{
    for (const std::string& side : {left, right}) {
        const std::string ours = side == left ? "left_" : "right_";
        for (const auto& row : limbs) {
            const auto filled = [&](std::string text) {
                const std::size_t at = text.find('%');
                if (at != std::string::npos) text.replace(at, 1, side);
                return text;
            };
            rows.push_back({filled(row[0]), filled(row[1]), ours + row[2]});
        }
    }
}

void add_fingers(Rows& limbs, const std::string& hand, const std::vector<std::string>& names,
                 const std::string& before_number, const std::string& after_number)
{
    const char* ours[] = {"thumb", "index", "middle", "ring", "pinky"};
    for (int f = 0; f < 5; ++f) {
        for (int k = 1; k <= 3; ++k) {
            const auto name = [&](int n) { return names[f] + before_number + std::to_string(n) + after_number; };
            limbs.push_back({name(k), k == 1 ? hand : name(k - 1), std::string(ours[f]) + "_" + std::to_string(k)});
        }
    }
}

MotionClip mixamo()
{
    const std::string m = "mixamorig:";
    Rows rows = {{m + "Hips", "", "pelvis"},
                 {m + "Spine", m + "Hips", "spine_2"},
                 {m + "Spine1", m + "Spine", "spine_3"},
                 {m + "Spine2", m + "Spine1", "spine_5"},
                 {m + "Neck", m + "Spine2", "neck_1"},
                 {m + "Head", m + "Neck", "head"},
                 {m + "HeadTop_End", m + "Head", "left_eye"}};
    Rows limbs = {{m + "%Shoulder", m + "Spine2", "clavicle"}, {m + "%Arm", m + "%Shoulder", "upper_arm"},
                  {m + "%ForeArm", m + "%Arm", "forearm"},     {m + "%Hand", m + "%ForeArm", "hand"},
                  {m + "%UpLeg", m + "Hips", "thigh"},         {m + "%Leg", m + "%UpLeg", "shin"},
                  {m + "%Foot", m + "%Leg", "foot"},           {m + "%ToeBase", m + "%Foot", "toes"}};
    std::vector<std::string> fingers;
    for (const char* finger : {"Thumb", "Index", "Middle", "Ring", "Pinky"}) fingers.push_back(m + "%Hand" + finger);
    add_fingers(limbs, m + "%Hand", fingers, "", "");
    add_limbs(rows, limbs, "Left", "Right");
    return make_rig("mixamo", rows);
}

MotionClip unreal(int num_spine)
{
    Rows rows = {{"root", "", "pelvis"}, {"pelvis", "root", "pelvis"}};
    for (int k = 1; k <= num_spine; ++k) {
        const std::string parent = k == 1 ? "pelvis" : "spine_0" + std::to_string(k - 1);
        rows.push_back({"spine_0" + std::to_string(k), parent, "spine_" + std::to_string(k + 5 - num_spine)});
    }
    const std::string chest = "spine_0" + std::to_string(num_spine);
    rows.push_back({"neck_01", chest, "neck_1"});
    if (num_spine == 5) rows.push_back({"neck_02", "neck_01", "neck_2"});
    rows.push_back({"head", num_spine == 5 ? "neck_02" : "neck_01", "head"});
    Rows limbs = {{"clavicle_%", chest, "clavicle"},
                  {"upperarm_%", "clavicle_%", "upper_arm"},
                  {"upperarm_twist_01_%", "upperarm_%", "upper_arm"},
                  {"lowerarm_%", "upperarm_%", "forearm"},
                  {"lowerarm_twist_01_%", "lowerarm_%", "forearm_twist"},
                  {"hand_%", "lowerarm_%", "hand"},
                  {"thigh_%", "pelvis", "thigh"},
                  {"thigh_twist_01_%", "thigh_%", "thigh"},
                  {"calf_%", "thigh_%", "shin"},
                  {"foot_%", "calf_%", "foot"},
                  {"ball_%", "foot_%", "toes"}};
    add_fingers(limbs, "hand_%", {"thumb", "index", "middle", "ring", "pinky"}, "_0", "_%");
    add_limbs(rows, limbs, "l", "r");
    return make_rig(num_spine == 5 ? "unreal 5" : "unreal 4", rows);
}

MotionClip smpl()
{
    Rows rows = {{"pelvis", "", "pelvis"},        {"spine1", "pelvis", "spine_2"}, {"spine2", "spine1", "spine_3"},
                 {"spine3", "spine2", "spine_4"}, {"neck", "spine3", "neck_1"},    {"head", "neck", "head"}};
    add_limbs(rows,
              {{"%_hip", "pelvis", "thigh"},
               {"%_knee", "%_hip", "shin"},
               {"%_ankle", "%_knee", "foot"},
               {"%_foot", "%_ankle", "toes"},
               {"%_collar", "spine3", "clavicle"},
               {"%_shoulder", "%_collar", "upper_arm"},
               {"%_elbow", "%_shoulder", "forearm"},
               {"%_wrist", "%_elbow", "hand"}},
              "left", "right");
    return make_rig("smpl", rows);
}

const std::vector<std::string> main_joints = {
    "pelvis",         "spine_1",        "spine_2",         "spine_3",      "spine_4",
    "spine_5",        "neck_1",         "neck_2",          "head",         "left_clavicle",
    "right_clavicle", "left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm",
    "left_hand",      "right_hand",     "left_thigh",      "right_thigh",  "left_shin",
    "right_shin",     "left_foot",      "right_foot",      "left_toes",    "right_toes"};

/// Main joints of the written map, and how many of them the proposal drives by the same joints.
struct Agreement {
    int agree = 0, total = 0;
    std::string differing;
};

Agreement compare(const JointMap& written, const JointMap& proposed)
{
    Agreement result;
    for (const std::string& joint : main_joints) {
        const JointMapEntry *a = written.find(joint), *b = proposed.find(joint);
        if (a == nullptr) continue;
        ++result.total;
        // Where the spine blends is a choice; which joints it blends is not.
        const bool same = b != nullptr && (a->source == b->source || a->source == b->blend_with ||
                                           (!a->blend_with.empty() && a->blend_with == b->source));
        const bool aligned = b == nullptr || a->toward.empty() || a->toward == b->toward;
        if (same && aligned) {
            ++result.agree;
        } else {
            result.differing += " " + joint + " (" + a->source + ", " + (b ? b->source : "none") + ")";
        }
    }
    return result;
}

JointMap map_for(const std::vector<JointMap>& maps, const MotionClip& clip)
{
    const std::optional<JointMap> map = find_joint_map(maps, clip);
    INFO(clip.name);
    REQUIRE(map);
    return *map;
}

/// One clip of every rig of the data.
std::vector<MotionClip> data_rigs()
{
    const std::string folder = test::data_folder();
    std::vector<MotionClip> clips;
    if (folder.empty()) return clips;
    for (const char* path :
         {"cmu_asfamc/02/02_01.amc", "hdm05_bk_asfamc/HDM_bk_squat1Reps_014_120.amc", "cmu_bvh/02_01.bvh",
          "cmu_bvh/jumping_jacks.bvh", "cmu_daz_bvh/salsa_29.bvh", "makehuman_poses/run01.bvh",
          "makehuman_poses/tpose.bvh", "deepmimic/humanoid3d_walk.txt"}) {
        for (const MotionFile& file : find_motion_files({folder + "/motion/" + path}))
            clips.push_back(read_motion(file));
    }
    return clips;
}

}  // namespace

TEST_CASE("names of joints are taken apart")
{
    const std::vector<JointName> names =
        parse_joint_names({"mixamorig:LeftForeArm", "lShldr", "rShldr", "upperleg01.L", "upperleg01.R", "thigh_l",
                           "thigh_r", "lowerneck", "left_hip", "CC_Base_L_Hand", "CC_Base_R_Hand", "ltibia", "rtibia",
                           "lradius", "Bip01 R Toe0", "Bip01 L Toe0"});
    const std::vector<Side> sides = {Side::left,  Side::left, Side::right, Side::left, Side::right, Side::left,
                                     Side::right, Side::none, Side::left,  Side::left, Side::right, Side::left,
                                     Side::right, Side::none, Side::right, Side::left};
    for (std::size_t k = 0; k < names.size(); ++k) {
        INFO(k);
        CHECK(names[k].side == sides[k]);
    }
    CHECK(names[0].words == std::vector<std::string>{"fore", "arm"});
    CHECK(names[1].joined == "shldr");
    CHECK(names[3].joined == "upperleg");
    CHECK(names[3].numbers == std::vector<int>{1});
    CHECK(names[7].joined == "lowerneck");
    CHECK(names[14].joined == "biptoe");
}

TEST_CASE("each made rig has one map of its own")
{
    const std::vector<JointMap> maps = read_joint_maps(config_path("joint-maps"));
    for (const auto& [clip, file] : std::vector<std::pair<MotionClip, std::string>>{{mixamo(), "mixamo.json"},
                                                                                    {unreal(3), "unreal-4.json"},
                                                                                    {unreal(5), "unreal-5.json"},
                                                                                    {smpl(), "smplh.json"}}) {
        CHECK(std::filesystem::path(map_for(maps, clip).path).filename() == file);
    }
}

TEST_CASE("proposals for made rigs agree with the maps written for them")
{
    const std::vector<JointMap> maps = read_joint_maps(config_path("joint-maps"));
    for (const MotionClip& clip : {mixamo(), unreal(3), unreal(5), smpl()}) {
        const JointMapProposal proposal = propose_joint_map(clip);
        const Agreement agreement = compare(map_for(maps, clip), proposal.map);
        INFO(clip.name << ":" << agreement.differing);
        CHECK(proposal.sides_from_names);
        CHECK(agreement.total == 25);
        CHECK(agreement.agree == agreement.total);
        if (clip.name == "smpl") continue;
        for (const char* joint : {"left_thumb_1", "right_index_3", "left_middle_2", "right_pinky_1"}) {
            REQUIRE(proposal.map.find(joint) != nullptr);
            CHECK(proposal.map.find(joint)->source == map_for(maps, clip).find(joint)->source);
        }
    }
}

TEST_CASE("a rig without names is recognised by its shape, whatever its axes")
{
    const std::vector<JointMap> maps = read_joint_maps(config_path("joint-maps"));
    for (const MotionClip& named : {mixamo(), unreal(5), smpl()}) {
        for (const bool turned : {false, true}) {
            MotionClip clip = named;
            for (int j = 0; j < clip.num_joints(); ++j) clip.joint_names[j] = "bone_" + std::to_string(j);
            if (turned) {
                // z up, facing -y, in centimetres.
                Eigen::Matrix3d turn;
                turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
                clip.zero_pose_positions = (100.0 * clip.zero_pose_positions * turn.transpose()).eval();
                clip.zero_pose_tips = (100.0 * clip.zero_pose_tips * turn.transpose()).eval();
            }
            JointMap proposed = propose_joint_map(clip).map;
            for (JointMapEntry& entry : proposed.entries) {
                for (std::string* name : {&entry.source, &entry.blend_with}) {
                    if (!name->empty()) *name = named.joint_names[std::size_t(std::stoi(name->substr(5)))];
                }
            }
            const Agreement agreement = compare(map_for(maps, named), proposed);
            INFO(clip.name << ":" << agreement.differing);
            CHECK(agreement.total == 25);
            CHECK(agreement.agree >= 23);
        }
    }
}

TEST_CASE("proposals are written as maps that are read back")
{
    const test::TemporaryFolder folder;
    const JointMapProposal proposal = propose_joint_map(mixamo());
    write_file(folder.file("map.json"), joint_map_json(proposal.map, "says \"check\""));
    const JointMap read = read_joint_map(folder.file("map.json"));
    REQUIRE(read.entries.size() == proposal.map.entries.size());
    for (const JointMapEntry& a : proposal.map.entries) {
        const JointMapEntry* b = read.find(a.joint);
        INFO(a.joint);
        REQUIRE(b != nullptr);
        CHECK(a.source == b->source);
        CHECK(a.blend_with == b->blend_with);
        CHECK(a.fraction == Approx(b->fraction));
        CHECK(a.twist_only == b->twist_only);
        CHECK(a.toward == b->toward);
        CHECK(a.bone_from == b->bone_from);
        CHECK(a.bone_to == b->bone_to);
        CHECK(a.sole == b->sole);
        CHECK(a.up_from == b->up_from);
        CHECK(a.limit == Approx(b->limit));
    }
    CHECK(missing_source_joint(read, mixamo()).empty());
    const JointMap ue4 = read_joint_map(config_path("joint-maps/unreal-4.json"));
    CHECK(missing_source_joint(ue4, unreal(5)) == "no spine_04");
    CHECK(missing_source_joint(ue4, unreal(3)).empty());
    write_file(folder.file("bad.json"), R"({"without": [3], "joints": {}})");
    CHECK_THROWS_WITH(read_joint_map(folder.file("bad.json")), Contains("without[0]: expected a text, got 3"));
}

TEST_CASE("what is no body gets no proposal")
{
    MotionClip clip = make_rig("snake", {{"a", "", "pelvis"}, {"b", "a", "spine_1"}, {"c", "b", "spine_2"}});
    CHECK_THROWS_AS(propose_joint_map(clip), InputError);
    CHECK_THROWS_WITH(propose_joint_map(clip), Contains("clip snake") && Contains("mirrored branches"));
    clip.zero_pose_positions.setZero();
    CHECK_THROWS_WITH(propose_joint_map(clip), Contains("in one place"));
}

TEST_CASE("every rig of the data has one map, and proposals agree with it", "[data]")
{
    const std::vector<JointMap> maps = read_joint_maps(config_path("joint-maps"));
    int agree = 0, total = 0;
    for (const MotionClip& clip : data_rigs()) {
        const JointMap map = map_for(maps, clip);
        const JointMapProposal proposal = propose_joint_map(clip);
        CHECK(missing_source_joint(proposal.map, clip).empty());
        const Agreement agreement = compare(map, proposal.map);
        INFO(clip.name << ": " << agreement.agree << " of " << agreement.total << ":" << agreement.differing);
        CHECK(agreement.agree >= agreement.total - 2);
        agree += agreement.agree;
        total += agreement.total;
    }
    CHECK(agree >= 0.95 * total);
}
