// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/joint_map.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace ndg {

namespace {

using nlohmann::json;

class MapReader {
public:
    explicit MapReader(const std::string& path) { map_.path = path; }

    JointMap read(const json& root)
    {
        check_keys(root, {"description", "skip_first_frames", "without", "joints"}, "the map");
        if (root.contains("skip_first_frames")) {
            const json& skip = root["skip_first_frames"];
            require_input(skip.is_number_integer() && skip >= 0, "{}: skip_first_frames is {}, not a count", map_.path,
                          skip.dump());
            map_.skip_first_frames = skip.get<int>();
        }
        if (root.contains("without")) {
            require_input(root["without"].is_array(), "{}: \"without\" is {}, not a list of joints", map_.path,
                          root["without"].dump());
            for (const json& joint : root["without"]) {
                require_input(joint.is_string(), "{}: \"without\" has the entry {}, no joint", map_.path, joint.dump());
                map_.without.push_back(joint.get<std::string>());
            }
        }
        require_input(root.contains("joints") && root["joints"].is_object(), "{}: has no object \"joints\"", map_.path);
        for (const auto& [joint, value] : root["joints"].items()) map_.entries.push_back(read_entry(joint, value));
        // Pelvis, hips, knees and ankles carry the root's motion and the leg length.
        for (const char* joint :
             {"pelvis", "left_thigh", "right_thigh", "left_shin", "right_shin", "left_foot", "right_foot"}) {
            require_input(map_.find(joint) != nullptr, "{}: has no entry for \"{}\"", map_.path, joint);
        }
        return map_;
    }

private:
    JointMapEntry read_entry(const std::string& joint, const json& value) const
    {
        const auto& names = standard_skeleton().joint_names;
        require_input(std::find(names.begin(), names.end(), joint) != names.end(),
                      "{}: \"{}\" is not one of our joints", map_.path, joint);
        JointMapEntry entry;
        entry.joint = joint;
        if (value.is_string()) {
            entry.source = value.get<std::string>();
            return entry;
        }
        check_keys(value,
                   {"source", "blend_with", "fraction", "twist_only", "toward", "bone", "sole", "up", "limit_degrees"},
                   joint);
        require_input(value.contains("source"), "{}: joint \"{}\" has no \"source\"", map_.path, joint);
        entry.source = text(value, "source", joint);
        entry.blend_with = text(value, "blend_with", joint);
        if (value.contains("fraction")) {
            const json& fraction = value["fraction"];
            require_input(fraction.is_number() && fraction >= 0.0 && fraction <= 1.0,
                          "{}: fraction of \"{}\" is {}, not a number in [0, 1]", map_.path, joint, fraction.dump());
            entry.fraction = fraction.get<double>();
        }
        if (value.contains("limit_degrees")) {
            const json& limit = value["limit_degrees"];
            require_input(limit.is_number() && limit > 0.0 && limit <= 180.0,
                          "{}: limit_degrees of \"{}\" is {}, not a number in (0, 180]", map_.path, joint,
                          limit.dump());
            entry.limit = limit.get<double>() * M_PI / 180.0;
        }
        entry.twist_only = flag(value, "twist_only", joint);
        entry.sole = flag(value, "sole", joint);
        entry.toward = text(value, "toward", joint);
        require_input(entry.toward.empty() || std::find(names.begin(), names.end(), entry.toward) != names.end(),
                      "{}: \"toward\" of \"{}\" is \"{}\", not one of our joints", map_.path, joint, entry.toward);
        require_input(entry.toward.empty() != value.contains("bone"),
                      "{}: joint \"{}\" must have both or none of \"toward\" and \"bone\"", map_.path, joint);
        if (value.contains("bone")) pair(value["bone"], "bone", joint, entry.bone_from, entry.bone_to);
        if (value.contains("up")) pair(value["up"], "up", joint, entry.up_from, entry.up_to);
        require_input(!entry.sole || !entry.toward.empty(), "{}: joint \"{}\" has \"sole\" without \"toward\"",
                      map_.path, joint);
        return entry;
    }

    void check_keys(const json& object, const std::vector<std::string>& known, const std::string& where) const
    {
        require_input(object.is_object(), "{}: {} is not a JSON object", map_.path, where);
        for (const auto& item : object.items()) {
            require_input(std::find(known.begin(), known.end(), item.key()) != known.end(),
                          "{}: unknown key \"{}\" in {}", map_.path, item.key(), where);
        }
    }

    std::string text(const json& value, const char* key, const std::string& joint) const
    {
        if (!value.contains(key)) return "";
        require_input(value[key].is_string(), "{}: \"{}\" of \"{}\" is {}, not text", map_.path, key, joint,
                      value[key].dump());
        return value[key].get<std::string>();
    }

    bool flag(const json& value, const char* key, const std::string& joint) const
    {
        if (!value.contains(key)) return false;
        require_input(value[key].is_boolean(), "{}: \"{}\" of \"{}\" is {}, not true or false", map_.path, key, joint,
                      value[key].dump());
        return value[key].get<bool>();
    }

    /// [from, to], or [from] for the tip of the bone.
    void pair(const json& value, const char* key, const std::string& joint, std::string& from, std::string& to) const
    {
        const bool valid = value.is_array() && (value.size() == 1 || value.size() == 2) && value[0].is_string() &&
                           value[value.size() - 1].is_string();
        require_input(valid, "{}: \"{}\" of \"{}\" is {}, not one or two joint names", map_.path, key, joint,
                      value.dump());
        from = value[0].get<std::string>();
        if (value.size() == 2) to = value[1].get<std::string>();
    }

    JointMap map_;
};

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
    std::ifstream file(path);
    require_input(file.good(), "{}: cannot be read", path);
    json root;
    try {
        root = json::parse(file);
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: is not valid JSON: {}", path, error.what()));
    }
    return MapReader(path).read(root);
}

std::string joint_map_json(const JointMap& map, const std::string& description)
{
    const auto quoted = [](const std::string& text) { return json(text).dump(); };
    std::string text = "{\n  \"description\": " + quoted(description) + ",\n";
    if (map.skip_first_frames > 0) text += fmt::format("  \"skip_first_frames\": {},\n", map.skip_first_frames);
    if (!map.without.empty()) text += "  \"without\": " + json(map.without).dump() + ",\n";
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

const JointMap* find_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip)
{
    const JointMap* found = nullptr;
    for (const JointMap& map : maps) {
        if (!missing_source_joint(map, clip).empty()) continue;
        require_input(found == nullptr, "clip {}: the joint maps {} and {} both fit, name one", clip.name,
                      found ? found->path : "", map.path);
        found = &map;
    }
    return found;
}

}  // namespace ndg
