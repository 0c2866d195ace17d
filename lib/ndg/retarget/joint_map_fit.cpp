// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/retarget/joint_map.h"
#include "ndg/retarget/joint_map_names.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace ndg {

namespace {

/// Whether a map fits a rig without this joint of ours.
bool is_optional(const std::string& joint)
{
    for (const char* part : {"thumb", "index", "middle", "ring", "pinky", "jaw", "eye", "toes"}) {
        if (joint.find(part) != std::string::npos) return true;
    }
    return false;
}

std::vector<std::string> names_of(const JointMap& map)
{
    std::set<std::string> names(map.without.begin(), map.without.end());
    for (const JointMapEntry& entry : map.entries) {
        for (const std::string& name :
             {entry.source, entry.blend_with, entry.bone_from, entry.bone_to, entry.up_from, entry.up_to}) {
            if (!name.empty()) names.insert(name);
        }
    }
    return {names.begin(), names.end()};
}

/// The clip's joint for each name of a map, "" where it has none.
std::map<std::string, std::string> match_names(const std::vector<std::string>& names, const MotionClip& clip)
{
    std::map<std::string, std::vector<std::string>> of_key;
    const std::vector<std::string> clip_keys = joint_name_keys(clip.joint_names);
    for (std::size_t j = 0; j < clip_keys.size(); ++j) of_key[clip_keys[j]].push_back(clip.joint_names[j]);
    std::map<std::string, std::string> matches;
    const std::vector<std::string> keys = joint_name_keys(names);
    for (std::size_t k = 0; k < names.size(); ++k) {
        const auto found = of_key.find(keys[k]);
        std::string& match = matches[names[k]];
        if (clip.find_joint(names[k]) >= 0) {
            match = names[k];
        } else if (found != of_key.end() && found->second.size() == 1) {
            match = found->second.front();
        }
    }
    return matches;
}

void add_once(std::vector<std::string>& list, const std::string& text)
{
    if (std::find(list.begin(), list.end(), text) == list.end()) list.push_back(text);
}

}  // namespace

JointMapFit fit_joint_map(const JointMap& map, const MotionClip& clip)
{
    const std::map<std::string, std::string> matches = match_names(names_of(map), clip);
    JointMapFit fit;
    fit.map = map;
    fit.map.entries.clear();
    fit.map.without.clear();
    for (const std::string& joint : map.without) {
        if (!matches.at(joint).empty()) fit.missing.push_back("no " + joint);
    }
    for (JointMapEntry entry : map.entries) {
        const auto has = [&](const std::string& name) { return name.empty() || !matches.at(name).empty(); };
        if (is_optional(entry.joint) && (!has(entry.source) || !has(entry.blend_with))) continue;
        if (is_optional(entry.toward) && !has(entry.bone_to)) {
            // The joint follows its parent then.
            entry.toward.clear();
            entry.sole = false;
            for (std::string* name : {&entry.bone_from, &entry.bone_to, &entry.up_from, &entry.up_to}) name->clear();
        }
        for (std::string* name :
             {&entry.source, &entry.blend_with, &entry.bone_from, &entry.bone_to, &entry.up_from, &entry.up_to}) {
            if (name->empty()) continue;
            if (!has(*name)) add_once(fit.missing, *name);
            *name = matches.at(*name);
        }
        fit.map.entries.push_back(entry);
    }
    for (const auto& [name, match] : matches) {
        if (match.empty()) continue;
        ++fit.num_joints;
        if (match == name) ++fit.num_literal;
    }
    return fit;
}

std::optional<JointMap> find_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip)
{
    std::optional<JointMapFit> best;
    std::string equal;
    for (const JointMap& map : maps) {
        JointMapFit fit = fit_joint_map(map, clip);
        if (!fit.missing.empty()) continue;
        const auto rank = [](const JointMapFit& f) { return std::make_tuple(f.num_joints, f.num_literal); };
        if (best && rank(fit) < rank(*best)) continue;
        equal = best && rank(fit) == rank(*best) ? map.path : "";
        if (equal.empty()) best = std::move(fit);
    }
    if (!best) return std::nullopt;
    require_input(equal.empty(), "clip {}: the joint maps {} and {} both fit, name one", clip.name, best->map.path,
                  equal);
    return best->map;
}

std::string nearest_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip)
{
    constexpr std::size_t most_named = 4;
    std::string text;
    std::size_t least = 0;
    for (const JointMap& map : maps) {
        const std::vector<std::string> missing = fit_joint_map(map, clip).missing;
        if (!text.empty() && missing.size() >= least) continue;
        least = missing.size();
        std::vector<std::string> named;
        for (std::size_t k = 0; k < std::min(least, most_named); ++k) named.push_back("\"" + missing[k] + "\"");
        text = fmt::format("{} lacks {}{}", map.path, fmt::join(named, ", "),
                           least > most_named ? fmt::format(" and {} more", least - most_named) : "");
    }
    return text;
}

}  // namespace ndg
