// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/joint_map.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace ndg {

namespace {

bool is_our_joint(const std::string& name)
{
    const auto& names = standard_skeleton().joint_names;
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// [from, to], or [from] for the tip of the bone.
void read_pair(const JsonValue& value, std::string& from, std::string& to)
{
    const std::vector<JsonValue> names = value.elements();
    value.expect(names.size() == 1 || names.size() == 2, "one or two joint names");
    from = names[0].text();
    if (names.size() == 2) to = names[1].text();
}

JointMapEntry read_entry(const std::string& joint, const JsonValue& value)
{
    require_input(is_our_joint(joint), "{}: \"{}\" is not one of our joints", value.where(), joint);
    JointMapEntry entry;
    entry.joint = joint;
    if (value.is_text()) {
        entry.source = value.text();
        return entry;
    }
    value.check_keys(
        {"source", "blend_with", "fraction", "twist_only", "toward", "bone", "sole", "up", "limit_degrees"});
    entry.source = value.at("source").text();
    entry.blend_with = value.text_or("blend_with", "");
    entry.fraction = value.number_or("fraction", entry.fraction, 0.0, 1.0);
    if (value.has("limit_degrees")) {
        const JsonValue limit = value.at("limit_degrees");
        limit.expect(limit.number() > 0.0 && limit.number() <= 180.0, "a number in (0, 180]");
        entry.limit = limit.number() * M_PI / 180.0;
    }
    entry.twist_only = value.flag_or("twist_only", false);
    entry.sole = value.flag_or("sole", false);
    entry.toward = value.text_or("toward", "");
    require_input(entry.toward.empty() || is_our_joint(entry.toward), "{}: \"toward\" is \"{}\", not one of our joints",
                  value.where(), entry.toward);
    require_input(entry.toward.empty() != value.has("bone"), "{}: must have both or none of \"toward\" and \"bone\"",
                  value.where());
    if (value.has("bone")) read_pair(value.at("bone"), entry.bone_from, entry.bone_to);
    if (value.has("up")) read_pair(value.at("up"), entry.up_from, entry.up_to);
    require_input(!entry.sole || !entry.toward.empty(), "{}: has \"sole\" without \"toward\"", value.where());
    return entry;
}

}  // namespace

const JointMapEntry* JointMap::find(const std::string& joint) const
{
    for (const JointMapEntry& entry : entries) {
        if (entry.joint == joint) return &entry;
    }
    return nullptr;
}

JointMap read_joint_map(const std::string& path)
{
    const JsonValue root(path);
    root.check_keys({"description", "skip_first_frames", "without", "joints"});
    JointMap map;
    map.path = path;
    if (root.has("skip_first_frames")) map.skip_first_frames = root.at("skip_first_frames").integer(0);
    if (root.has("without")) {
        for (const JsonValue& joint : root.at("without").elements()) map.without.push_back(joint.text());
    }
    for (const auto& [joint, value] : root.at("joints").members()) map.entries.push_back(read_entry(joint, value));
    // Pelvis, hips, knees and ankles carry the root's motion and the leg length.
    for (const char* joint :
         {"pelvis", "left_thigh", "right_thigh", "left_shin", "right_shin", "left_foot", "right_foot"}) {
        require_input(map.find(joint) != nullptr, "{}: has no entry for \"{}\"", path, joint);
    }
    return map;
}

std::string joint_map_json(const JointMap& map, const std::string& description)
{
    const auto quoted = [](const std::string& text) { return nlohmann::json(text).dump(); };
    std::string text = "{\n  \"description\": " + quoted(description) + ",\n";
    if (map.skip_first_frames > 0) text += fmt::format("  \"skip_first_frames\": {},\n", map.skip_first_frames);
    if (!map.without.empty()) text += "  \"without\": " + nlohmann::json(map.without).dump() + ",\n";
    text += "  \"joints\": {\n";
    for (std::size_t k = 0; k < map.entries.size(); ++k) {
        const JointMapEntry& entry = map.entries[k];
        std::vector<std::string> parts = {"\"source\": " + quoted(entry.source)};
        if (!entry.blend_with.empty()) {
            parts.push_back("\"blend_with\": " + quoted(entry.blend_with));
            parts.push_back(fmt::format("\"fraction\": {}", entry.fraction));
        }
        if (entry.twist_only) parts.emplace_back("\"twist_only\": true");
        if (!entry.toward.empty()) {
            const auto pair = [&](const std::string& from, const std::string& to) {
                return "[" + quoted(from) + (to.empty() ? "" : ", " + quoted(to)) + "]";
            };
            parts.push_back("\"toward\": " + quoted(entry.toward));
            parts.push_back("\"bone\": " + pair(entry.bone_from, entry.bone_to));
            if (entry.sole) parts.emplace_back("\"sole\": true");
            if (!entry.up_from.empty()) parts.push_back("\"up\": " + pair(entry.up_from, entry.up_to));
        }
        if (entry.limit <= M_PI) {
            parts.push_back(fmt::format("\"limit_degrees\": {}", std::round(1e6 * entry.limit * 180.0 / M_PI) / 1e6));
        }
        text += "    " + quoted(entry.joint) + ": ";
        text += parts.size() == 1 ? quoted(entry.source) : fmt::format("{{{}}}", fmt::join(parts, ", "));
        text += k + 1 < map.entries.size() ? ",\n" : "\n";
    }
    return text + "  }\n}\n";
}

std::string missing_source_joint(const JointMap& map, const MotionClip& clip)
{
    for (const std::string& joint : map.without) {
        if (clip.find_joint(joint) >= 0) return "no " + joint;
    }
    for (const JointMapEntry& entry : map.entries) {
        for (const std::string& name :
             {entry.source, entry.blend_with, entry.bone_from, entry.bone_to, entry.up_from, entry.up_to}) {
            if (!name.empty() && clip.find_joint(name) < 0) return name;
        }
    }
    return "";
}

std::vector<JointMap> read_joint_maps(const std::string& folder)
{
    namespace fs = std::filesystem;
    require_input(fs::is_directory(folder), "{}: is not a folder of joint maps", folder);
    std::vector<std::string> files;
    for (const fs::path& file : fs::directory_iterator(folder)) {
        if (file.extension() == ".json") files.push_back(file.string());
    }
    require_input(!files.empty(), "{}: holds no joint map (*.json)", folder);
    std::sort(files.begin(), files.end());
    std::vector<JointMap> maps;
    for (const std::string& file : files) maps.push_back(read_joint_map(file));
    return maps;
}

}  // namespace ndg
