// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "ndg/io/motion_text.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double assumed_frame_rate = 120.0;
constexpr double metres_per_inch = 0.0254;

using Words = std::vector<std::string_view>;

struct Bone {
    std::string name;
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    double length = 0.0;
    Eigen::Vector3d axis_angles = Eigen::Vector3d::Zero();  ///< in the file's angle unit
    std::string axis_order = "xyz";
    std::string dofs;  ///< axis letters in the order of the AMC's values
    int parent = -1;
};

struct AcclaimSkeleton {
    std::vector<Bone> bones;  ///< bones[0] is the root
    std::string root_order;   ///< six letters: "XYZ" translations, "xyz" rotations, in the AMC's order
    Eigen::Vector3d root_position = Eigen::Vector3d::Zero();
    double radians_per_unit = radians_per_degree;
    double length_unit = 1.0;

    int find(std::string_view name) const
    {
        for (std::size_t b = 0; b < bones.size(); ++b) {
            if (bones[b].name == name) return static_cast<int>(b);
        }
        return -1;
    }
};

std::string lower(std::string_view word)
{
    std::string text(word);
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

void need_words(const MotionText& text, const Words& words, std::size_t count)
{
    if (words.size() < count) {
        text.fail(fmt::format("'{}' has {} values, {} are needed", words[0], words.size() - 1, count - 1));
    }
}

Eigen::Vector3d parse_vector(const MotionText& text, const Words& words)
{
    need_words(text, words, 4);
    Eigen::Vector3d vector;
    for (int k = 0; k < 3; ++k) vector[k] = text.number(words[k + 1], words[0]);
    return vector;
}

std::string parse_axis_order(const MotionText& text, std::string_view word)
{
    const std::string order = lower(word);
    std::string sorted = order;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != "xyz") text.fail(fmt::format("axis order '{}' is not a permutation of XYZ", word));
    return order;
}

/// Rotations about the axes of `order`, the first letter applied first: order "xyz" gives Rz Ry Rx.
Eigen::Matrix3d euler_rotation(const std::string& order, const Eigen::Vector3d& radians)
{
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    for (const char axis : order) rotation = (axis_rotation(axis, radians[axis - 'x']) * rotation).eval();
    return rotation;
}

void parse_units(const MotionText& text, const Words& words, AcclaimSkeleton& skeleton)
{
    const std::string key = lower(words[0]);
    need_words(text, words, 2);
    if (key == "length") {
        skeleton.length_unit = text.number(words[1], "unit length");
        if (!(skeleton.length_unit > 0)) text.fail(fmt::format("unit length is {}", words[1]));
    } else if (key == "angle") {
        const std::string unit = lower(words[1]);
        if (unit != "deg" && unit != "rad") text.fail(fmt::format("unknown angle unit '{}'", words[1]));
        skeleton.radians_per_unit = unit == "deg" ? radians_per_degree : 1.0;
    } else if (key != "mass") {
        text.fail(fmt::format("unknown unit '{}'", words[0]));
    }
}

void parse_root(const MotionText& text, const Words& words, AcclaimSkeleton& skeleton)
{
    Bone& root = skeleton.bones[0];
    const std::string key = lower(words[0]);
    if (key == "order") {
        need_words(text, words, 7);
        for (std::size_t k = 1; k < 7; ++k) {
            const std::string channel = lower(words[k]);
            const bool known = channel.size() == 2 && (channel[0] == 't' || channel[0] == 'r') && channel[1] >= 'x' &&
                               channel[1] <= 'z';
            if (!known) text.fail(fmt::format("unknown root channel '{}'", words[k]));
            skeleton.root_order += channel[0] == 'r' ? channel[1] : static_cast<char>(channel[1] - 'x' + 'X');
        }
        std::string sorted = skeleton.root_order;
        std::sort(sorted.begin(), sorted.end());
        if (sorted != "XYZxyz") text.fail("the root order must name TX TY TZ RX RY RZ once each");
    } else if (key == "axis") {
        need_words(text, words, 2);
        root.axis_order = parse_axis_order(text, words[1]);
    } else if (key == "position") {
        skeleton.root_position = parse_vector(text, words);
    } else if (key == "orientation") {
        root.axis_angles = parse_vector(text, words);
    } else {
        text.fail(fmt::format("unknown keyword '{}' in :root", words[0]));
    }
}

void parse_dofs(const MotionText& text, const Words& words, Bone& bone)
{
    for (std::size_t k = 1; k < words.size(); ++k) {
        const std::string dof = lower(words[k]);
        if (dof.size() != 2 || dof[0] != 'r' || dof[1] < 'x' || dof[1] > 'z' ||
            bone.dofs.find(dof[1]) != std::string::npos) {
            text.fail(fmt::format("degree of freedom '{}' of bone '{}' is not one of rx, ry, rz", words[k], bone.name));
        }
        bone.dofs += dof[1];
    }
}

/// From "begin" (already read) to "end".
Bone parse_bone(MotionText& text)
{
    Bone bone;
    bool has_direction = false, has_length = false;
    while (true) {
        const Words words = text.next_line();
        if (words.empty()) text.fail(fmt::format("the file ends inside bone '{}'", bone.name));
        const std::string key = lower(words[0]);
        if (key == "end") break;
        if (key == "name") {
            need_words(text, words, 2);
            bone.name = std::string(words[1]);
        } else if (key == "direction") {
            bone.direction = parse_vector(text, words);
            has_direction = true;
        } else if (key == "length") {
            need_words(text, words, 2);
            bone.length = text.number(words[1], fmt::format("length of bone '{}'", bone.name));
            has_length = true;
        } else if (key == "axis") {
            bone.axis_angles = parse_vector(text, words);
            if (words.size() > 4) bone.axis_order = parse_axis_order(text, words[4]);
        } else if (key == "dof") {
            parse_dofs(text, words, bone);
        } else if (key != "id" && key != "limits" && key[0] != '(' && key != "bodymass" && key != "cofmass") {
            text.fail(fmt::format("unknown keyword '{}' in bone '{}'", words[0], bone.name));
        }
    }
    if (bone.name.empty()) text.fail("a bone has no name");
    if (!has_direction || !has_length) text.fail(fmt::format("bone '{}' lacks direction or length", bone.name));
    if (bone.length > 0 && bone.direction.norm() < 1e-6) {
        text.fail(fmt::format("the direction of bone '{}' is zero", bone.name));
    }
    if (bone.length < 0) text.fail(fmt::format("the length of bone '{}' is {}", bone.name, bone.length));
    return bone;
}

void parse_hierarchy(const MotionText& text, const Words& words, AcclaimSkeleton& skeleton)
{
    const int parent = skeleton.find(words[0]);
    if (parent < 0) text.fail(fmt::format("unknown bone '{}' in :hierarchy", words[0]));
    for (std::size_t k = 1; k < words.size(); ++k) {
        const int child = skeleton.find(words[k]);
        if (child < 0) text.fail(fmt::format("unknown bone '{}' in :hierarchy", words[k]));
        if (child == 0 || skeleton.bones[child].parent >= 0) {
            text.fail(fmt::format("bone '{}' has two parents", words[k]));
        }
        skeleton.bones[child].parent = parent;
    }
}

AcclaimSkeleton read_asf(const std::string& path)
{
    MotionText text(path);
    AcclaimSkeleton skeleton;
    Bone root;
    root.name = "root";
    skeleton.bones.push_back(root);
    std::string section;
    for (Words words = text.next_line(); !words.empty(); words = text.next_line()) {
        if (words[0][0] == '#') continue;
        if (words[0][0] == ':') {
            section = lower(words[0]);
            // What follows ":skin" (files of skins) is read over.
            static const std::vector<std::string> known = {":version", ":name",     ":units",     ":documentation",
                                                           ":root",    ":bonedata", ":hierarchy", ":skin"};
            if (std::find(known.begin(), known.end(), section) == known.end()) {
                text.fail(fmt::format("unknown section '{}'", words[0]));
            }
        } else if (section == ":units") {
            parse_units(text, words, skeleton);
        } else if (section == ":root") {
            parse_root(text, words, skeleton);
        } else if (section == ":bonedata") {
            if (lower(words[0]) != "begin") text.fail(fmt::format("expected 'begin' but found '{}'", words[0]));
            Bone bone = parse_bone(text);
            if (skeleton.find(bone.name) >= 0) text.fail(fmt::format("bone '{}' appears twice", bone.name));
            skeleton.bones.push_back(std::move(bone));
        } else if (section == ":hierarchy") {
            const std::string key = lower(words[0]);
            if (key != "begin" && key != "end") parse_hierarchy(text, words, skeleton);
        } else if (section.empty()) {
            text.fail(fmt::format("'{}' stands before the first section", words[0]));
        }
    }
    require_input(skeleton.root_order.size() == 6, "{}: has no root order", path);
    require_input(skeleton.bones.size() > 1, "{}: has no bones", path);
    return skeleton;
}

/// Bones in an order with parents before children; throws where a bone hangs nowhere.
std::vector<int> parents_first(const AcclaimSkeleton& skeleton, const std::string& path)
{
    std::vector<int> order = {0};
    for (std::size_t next = 0; next < order.size(); ++next) {
        for (std::size_t b = 1; b < skeleton.bones.size(); ++b) {
            if (skeleton.bones[b].parent == order[next]) order.push_back(static_cast<int>(b));
        }
    }
    for (std::size_t b = 1; b < skeleton.bones.size() && order.size() < skeleton.bones.size(); ++b) {
        require_input(std::find(order.begin(), order.end(), b) != order.end(),
                      "{}: bone '{}' is not connected to the root by :hierarchy", path, skeleton.bones[b].name);
    }
    return order;
}

/// Values of one frame of an AMC, one vector a bone.
using FrameValues = std::vector<std::vector<double>>;

class AmcReader {
public:
    AmcReader(const AcclaimSkeleton& skeleton, const std::string& path)
        : skeleton_(skeleton), text_(path), radians_per_unit_(skeleton.radians_per_unit)
    {
    }

    std::vector<FrameValues> read()
    {
        for (Words words = text_.next_line(); !words.empty(); words = text_.next_line()) {
            if (words[0][0] == '#') continue;
            if (words[0][0] == ':') {
                read_directive(words);
            } else if (words.size() == 1 && std::isdigit(static_cast<unsigned char>(words[0][0]))) {
                begin_frame(text_.number(words[0], "frame number"));
            } else {
                read_bone(words);
            }
        }
        if (frames_.empty()) text_.fail("the file has 0 frames");
        check_complete();
        return std::move(frames_);
    }

    double radians_per_unit() const { return radians_per_unit_; }
    /// 0 where the file does not say.
    double frame_rate() const { return frame_rate_; }

private:
    void read_directive(const Words& words)
    {
        const std::string directive = lower(words[0]);
        if (directive == ":samples-per-second") {
            need_words(text_, words, 2);
            frame_rate_ = text_.number(words[1], "the number of samples per second");
            if (!(frame_rate_ > 0)) text_.fail(fmt::format("the number of samples per second is {}", words[1]));
        } else if (directive == ":degrees")
            radians_per_unit_ = radians_per_degree;
        else if (directive == ":radians")
            radians_per_unit_ = 1.0;
        else if (directive != ":fully-specified")
            text_.fail(fmt::format("unknown keyword '{}'", directive));
    }

    void begin_frame(double number)
    {
        if (!frames_.empty()) {
            check_complete();
            if (number != number_ + 1) text_.fail(fmt::format("frame {} follows frame {}", number, number_));
        }
        number_ = number;
        frames_.emplace_back(skeleton_.bones.size());
    }

    void read_bone(const Words& words)
    {
        const int b = skeleton_.find(words[0]);
        if (b < 0) text_.fail(fmt::format("unknown bone '{}'", words[0]));
        if (frames_.empty()) text_.fail(fmt::format("bone '{}' stands before the first frame", words[0]));
        const std::size_t count = expected(b);
        if (words.size() - 1 != count) {
            text_.fail(fmt::format("bone '{}' has {} values in frame {}, the skeleton has {} channels", words[0],
                                   words.size() - 1, number_, count));
        }
        std::vector<double>& values = frames_.back()[b];
        if (!values.empty()) text_.fail(fmt::format("bone '{}' stands twice in frame {}", words[0], number_));
        for (std::size_t k = 0; k < count; ++k) {
            values.push_back(
                text_.number(words[k + 1], fmt::format("value {} of bone '{}' in frame {}", k, words[0], number_)));
        }
    }

    std::size_t expected(std::size_t b) const { return b == 0 ? 6 : skeleton_.bones[b].dofs.size(); }

    void check_complete() const
    {
        for (std::size_t b = 0; b < skeleton_.bones.size(); ++b) {
            if (frames_.back()[b].size() != expected(b)) {
                text_.fail(fmt::format("frame {} lacks bone '{}'", number_, skeleton_.bones[b].name));
            }
        }
    }

    const AcclaimSkeleton& skeleton_;
    MotionText text_;
    double radians_per_unit_;
    double number_ = 0, frame_rate_ = 0;
    std::vector<FrameValues> frames_;
};

/// Names, parents and zero-pose positions of the bones in `order`.
void set_skeleton(const AcclaimSkeleton& skeleton, const std::vector<int>& order, MotionClip& clip)
{
    const auto num_joints = static_cast<Eigen::Index>(order.size());
    std::vector<int> joint_of_bone(order.size());
    clip.zero_pose_positions = Points::Zero(num_joints, 3);
    clip.zero_pose_tips = Points::Zero(num_joints, 3);
    for (Eigen::Index j = 0; j < num_joints; ++j) {
        const Bone& bone = skeleton.bones[order[j]];
        joint_of_bone[order[j]] = static_cast<int>(j);
        clip.joint_names.push_back(bone.name);
        clip.parents.push_back(bone.parent < 0 ? -1 : joint_of_bone[bone.parent]);
        if (bone.parent < 0) continue;
        clip.zero_pose_positions.row(j) = clip.zero_pose_tips.row(clip.parents[j]);
        clip.zero_pose_tips.row(j) = clip.zero_pose_positions.row(j);
        if (bone.length > 0) clip.zero_pose_tips.row(j) += bone.length * bone.direction.normalized().transpose();
    }
}

/// Angles about x, y and z in a frame, in the AMC's unit; for the root also its position.
Eigen::Vector3d bone_angles(const AcclaimSkeleton& skeleton, int bone, const std::vector<double>& values,
                            Eigen::Vector3d& root_position)
{
    const std::string& channels = bone == 0 ? skeleton.root_order : skeleton.bones[bone].dofs;
    Eigen::Vector3d angles = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < channels.size(); ++k) {
        if (channels[k] >= 'x')
            angles[channels[k] - 'x'] = values[k];
        else
            root_position[channels[k] - 'X'] = values[k];
    }
    return angles;
}

}  // namespace

MotionClip read_asf_amc(const std::string& asf_path, const std::string& amc_path)
{
    const AcclaimSkeleton skeleton = read_asf(asf_path);
    const std::vector<int> order = parents_first(skeleton, asf_path);
    AmcReader reader(skeleton, amc_path);
    const std::vector<FrameValues> frames = reader.read();

    MotionClip clip;
    clip.name = file_stem(amc_path);
    clip.frame_rate_assumed = reader.frame_rate() <= 0;
    clip.frame_rate = clip.frame_rate_assumed ? assumed_frame_rate : reader.frame_rate();
    clip.metres_per_unit = metres_per_inch / skeleton.length_unit;
    set_skeleton(skeleton, order, clip);

    clip.root_positions.resize(static_cast<Eigen::Index>(frames.size()), 3);
    for (std::size_t f = 0; f < frames.size(); ++f) {
        std::vector<Eigen::Matrix3d> world_from_joint;
        Eigen::Vector3d root_position = Eigen::Vector3d::Zero();
        for (std::size_t j = 0; j < order.size(); ++j) {
            const Bone& bone = skeleton.bones[order[j]];
            const Eigen::Vector3d angles = bone_angles(skeleton, order[j], frames[f][order[j]], root_position);
            const Eigen::Matrix3d axis = euler_rotation(bone.axis_order, bone.axis_angles * skeleton.radians_per_unit);
            const Eigen::Matrix3d parent_from_joint =
                axis * euler_rotation(bone.axis_order, angles * reader.radians_per_unit()) * axis.transpose();
            const int parent = clip.parents[j];
            if (parent < 0)
                world_from_joint.push_back(parent_from_joint);
            else
                world_from_joint.push_back(world_from_joint[parent] * parent_from_joint);
        }
        clip.root_positions.row(static_cast<Eigen::Index>(f)) = (skeleton.root_position + root_position).transpose();
        clip.world_from_joint.push_back(std::move(world_from_joint));
    }
    return clip;
}

}  // namespace ndg
