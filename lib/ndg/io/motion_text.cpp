// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/motion_text.h"

#include "ndg/core/error.h"
#include "ndg/core/text_file.h"
#include "ndg/io/motion.h"

#include <Eigen/Geometry>

#include <charconv>
#include <cmath>
#include <filesystem>

namespace ndg {

namespace {

/// Longer messages (a binary file read as text) are cut.
constexpr std::size_t longest_message = 300;

bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

}  // namespace

MotionText::MotionText(const std::string& path) : path_(path)
{
    text_ = read_text_file(path);
    require_input(!text_.empty(), "{}: is empty", path);
}

std::string_view MotionText::next_word()
{
    while (position_ < text_.size() && is_blank(text_[position_])) {
        if (text_[position_] == '\n') ++line_;
        ++position_;
    }
    const std::size_t begin = position_;
    while (position_ < text_.size() && !is_blank(text_[position_])) ++position_;
    return std::string_view(text_).substr(begin, position_ - begin);
}

std::vector<std::string_view> MotionText::next_line()
{
    std::vector<std::string_view> words;
    std::string_view word = next_word();
    while (!word.empty()) {
        words.push_back(word);
        while (position_ < text_.size() && is_blank(text_[position_]) && text_[position_] != '\n') ++position_;
        if (position_ >= text_.size() || text_[position_] == '\n') break;
        word = next_word();
    }
    return words;
}

std::string_view MotionText::need_word(std::string_view expected)
{
    const std::string_view word = next_word();
    if (word.empty()) fail(fmt::format("the file ends where {} should stand", expected));
    return word;
}

double MotionText::need_number(std::string_view what)
{
    return number(need_word(what), what);
}

double MotionText::number(std::string_view word, std::string_view what) const
{
    double value = 0.0;
    const char* begin = word.data();
    const char* end = begin + word.size();
    if (begin != end && *begin == '+') ++begin;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error == std::errc::result_out_of_range && stop == end)
        value = std::strtod(std::string(word).c_str(), nullptr);
    else if (error != std::errc() || stop != end)
        fail(fmt::format("{} is '{}', not a number", what, word));
    if (!std::isfinite(value)) fail(fmt::format("{} is '{}', not a finite number", what, word));
    return value;
}

void MotionText::fail(const std::string& message) const
{
    const std::string end = message.size() > longest_message ? "..." : "";
    throw InputError(
        fmt::format("{}: line {}: {}{}", path_, line_, printable(message.substr(0, longest_message)), end));
}

Eigen::Matrix3d axis_rotation(char axis, double angle)
{
    const int idx = axis - 'x';
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(idx)).toRotationMatrix();
}

std::string file_stem(const std::string& path)
{
    return std::filesystem::path(path).stem().string();
}

int MotionClip::find_joint(const std::string& joint_name) const
{
    for (int j = 0; j < num_joints(); ++j) {
        if (joint_names[j] == joint_name) return j;
    }
    return -1;
}

Points MotionClip::joint_positions(int frame_idx) const
{
    Points positions(num_joints(), 3);
    for (int j = 0; j < num_joints(); ++j) {
        const int parent = parents[j];
        if (parent < 0) {
            positions.row(j) = root_positions.row(frame_idx);
            continue;
        }
        const Eigen::Vector3d bone = (zero_pose_positions.row(j) - zero_pose_positions.row(parent)).transpose();
        positions.row(j) = positions.row(parent) + (world_from_joint[frame_idx][parent] * bone).transpose();
    }
    return positions;
}

void turn_clip(MotionClip& clip, const Eigen::Matrix3d& turn)
{
    clip.zero_pose_positions = (clip.zero_pose_positions * turn.transpose()).eval();
    clip.zero_pose_tips = (clip.zero_pose_tips * turn.transpose()).eval();
    clip.root_positions = (clip.root_positions * turn.transpose()).eval();
    for (std::vector<Eigen::Matrix3d>& frame : clip.world_from_joint) {
        for (Eigen::Matrix3d& rotation : frame) rotation = (turn * rotation * turn.transpose()).eval();
    }
}

}  // namespace ndg
