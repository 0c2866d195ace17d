// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "ndg/io/motion_text.h"

#include <cmath>
#include <set>

namespace ndg {

namespace {

struct Channel {
    bool is_rotation = false;
    char axis = 'x';
};

struct Joint {
    std::string name;
    int parent = -1;
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    Eigen::Vector3d end_site = Eigen::Vector3d::Zero();
    bool has_offset = false, has_end_site = false;
    std::vector<Channel> channels;
};

Channel parse_channel(const MotionText& text, std::string_view word)
{
    const std::string_view kind = word.empty() ? word : word.substr(1);
    const char axis = word.empty() ? ' ' : static_cast<char>(word[0] | 0x20);
    if (axis < 'x' || axis > 'z' || (kind != "rotation" && kind != "position")) {
        text.fail(fmt::format("unknown channel '{}'", word));
    }
    return {kind == "rotation", axis};
}

Eigen::Vector3d parse_offset(MotionText& text)
{
    Eigen::Vector3d offset;
    for (int k = 0; k < 3; ++k) offset[k] = text.need_number("OFFSET");
    return offset;
}

void expect(MotionText& text, std::string_view expected)
{
    const std::string_view word = text.need_word(fmt::format("'{}'", expected));
    if (word != expected) text.fail(fmt::format("expected '{}' but found '{}'", expected, word));
}

void parse_end_site(MotionText& text, Joint& joint)
{
    expect(text, "Site");
    expect(text, "{");
    expect(text, "OFFSET");
    joint.end_site = parse_offset(text);
    joint.has_end_site = true;
    expect(text, "}");
}

std::vector<Channel> parse_channels(MotionText& text)
{
    const double count = text.need_number("the number of CHANNELS");
    if (count < 0 || count > 6 || count != std::floor(count)) {
        text.fail(fmt::format("a joint has {} channels, 0 to 6 are possible", count));
    }
    std::vector<Channel> channels;
    for (int k = 0; k < static_cast<int>(count); ++k) {
        channels.push_back(parse_channel(text, text.need_word("a channel name")));
    }
    return channels;
}

/// Reads "HIERARCHY ROOT ..." up to the root's closing brace.
std::vector<Joint> parse_hierarchy(MotionText& text)
{
    expect(text, "HIERARCHY");
    std::vector<Joint> joints;
    std::set<std::string> names;
    int current = -1;
    do {
        const std::string_view word = text.need_word("the next part of the hierarchy");
        if (word == "ROOT" || word == "JOINT") {
            if ((word == "ROOT") != joints.empty()) text.fail(fmt::format("misplaced '{}'", word));
            Joint joint;
            joint.name = std::string(text.need_word("a joint name"));
            joint.parent = current;
            if (!names.insert(joint.name).second) text.fail(fmt::format("joint '{}' appears twice", joint.name));
            expect(text, "{");
            current = static_cast<int>(joints.size());
            joints.push_back(joint);
        } else if (joints.empty()) {
            text.fail(fmt::format("expected 'ROOT' but found '{}'", word));
        } else if (word == "OFFSET") {
            joints[current].offset = parse_offset(text);
            joints[current].has_offset = true;
        } else if (word == "CHANNELS") {
            joints[current].channels = parse_channels(text);
        } else if (word == "End") {
            parse_end_site(text, joints[current]);
        } else if (word == "}") {
            if (!joints[current].has_offset) text.fail(fmt::format("joint '{}' has no OFFSET", joints[current].name));
            current = joints[current].parent;
        } else {
            text.fail(fmt::format("unknown keyword '{}'", word));
        }
    } while (current >= 0);
    return joints;
}

void set_skeleton(const std::vector<Joint>& joints, MotionClip& clip)
{
    const auto count = static_cast<Eigen::Index>(joints.size());
    clip.zero_pose_positions = Points::Zero(count, 3);
    clip.zero_pose_tips = Points::Zero(count, 3);
    std::vector<int> num_children(joints.size(), 0);
    for (Eigen::Index j = 0; j < count; ++j) {
        const Joint& joint = joints[j];
        clip.joint_names.push_back(joint.name);
        clip.parents.push_back(joint.parent);
        if (joint.parent < 0) continue;
        clip.zero_pose_positions.row(j) = clip.zero_pose_positions.row(joint.parent) + joint.offset.transpose();
        clip.zero_pose_tips.row(joint.parent) += clip.zero_pose_positions.row(j);
        ++num_children[joint.parent];
    }
    for (Eigen::Index j = 0; j < count; ++j) {
        if (num_children[j] > 0)
            clip.zero_pose_tips.row(j) /= num_children[j];
        else
            clip.zero_pose_tips.row(j) = clip.zero_pose_positions.row(j) + joints[j].end_site.transpose();
    }
}

/// One frame: `values` in the order of the channels, degrees.
void set_frame(const std::vector<Joint>& joints, const std::vector<double>& values, Eigen::Index frame_idx,
               MotionClip& clip)
{
    std::vector<Eigen::Matrix3d>& world_from_joint = clip.world_from_joint[frame_idx];
    world_from_joint.resize(joints.size());
    std::size_t next = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
        const Joint& joint = joints[j];
        Eigen::Matrix3d parent_from_joint = Eigen::Matrix3d::Identity();
        if (joint.parent < 0) clip.root_positions.row(frame_idx) = joint.offset.transpose();
        for (const Channel& channel : joint.channels) {
            const double value = values[next++];
            if (channel.is_rotation) {
                parent_from_joint *= axis_rotation(channel.axis, value * radians_per_degree);
            } else if (joint.parent < 0) {
                clip.root_positions(frame_idx, channel.axis - 'x') = value;
            }
        }
        if (joint.parent < 0)
            world_from_joint[j] = parent_from_joint;
        else
            world_from_joint[j] = world_from_joint[joint.parent] * parent_from_joint;
    }
}

int parse_frame_count(MotionText& text)
{
    expect(text, "MOTION");
    expect(text, "Frames:");
    const double count = text.need_number("the number of frames");
    if (count != std::floor(count) || count < 0 || count > 1e8) {
        text.fail(fmt::format("the number of frames is {}", count));
    }
    if (count == 0) text.fail("the file has 0 frames");
    return static_cast<int>(count);
}

}  // namespace

MotionClip read_bvh(const std::string& path)
{
    MotionText text(path);
    MotionClip clip;
    clip.name = file_stem(path);
    const std::vector<Joint> joints = parse_hierarchy(text);
    set_skeleton(joints, clip);
    std::size_t num_channels = 0;
    for (const Joint& joint : joints) num_channels += joint.channels.size();

    const int num_frames = parse_frame_count(text);
    expect(text, "Frame");
    expect(text, "Time:");
    const double frame_time = text.need_number("Frame Time");
    if (!(frame_time > 0)) text.fail(fmt::format("Frame Time is {}, it must be positive", frame_time));
    clip.frame_rate = 1.0 / frame_time;

    std::vector<double> values(num_channels);
    for (int frame_idx = 0; frame_idx < num_frames; ++frame_idx) {
        const std::vector<std::string_view> words = text.next_line();
        if (words.empty()) {
            text.fail(fmt::format("the file announces {} frames and ends after {}", num_frames, frame_idx));
        }
        if (words.size() != num_channels) {
            text.fail(fmt::format("frame {} has {} values, the hierarchy has {} channels", frame_idx, words.size(),
                                  num_channels));
        }
        for (std::size_t k = 0; k < num_channels; ++k) {
            values[k] = text.number(words[k], fmt::format("value {} of frame {}", k, frame_idx));
        }
        if (frame_idx == 0) clip.root_positions.resize(num_frames, 3);
        clip.world_from_joint.emplace_back();
        set_frame(joints, values, frame_idx, clip);
    }
    if (!text.next_line().empty()) text.fail(fmt::format("there are more frames than the {} announced", num_frames));
    return clip;
}

}  // namespace ndg
