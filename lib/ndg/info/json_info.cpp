// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/info/describers.h"
#include "ndg/motion/joint_limits.h"
#include "ndg/retarget/joint_map.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {
namespace {

using nlohmann::json;

/// A kind of JSON file: by members that all files of it have. `add` says more, where there is more to say.
struct JsonKind {
    std::vector<const char*> members;
    const char* what;
    void (*add)(const FileQuestion& file, const json& content, FileReport& report) = nullptr;
};

void add_joint_map(const FileQuestion& file, const json&, FileReport& report)
{
    const JointMap map = read_joint_map(file.path);
    report.add("joints", "{} of ours are driven", map.entries.size());
}

void add_joint_limits(const FileQuestion& file, const json& content, FileReport& report)
{
    const JointLimitTable table = read_joint_limits(file.path);
    report.add("joints", "{} have ranges", table.ranges.size());
    for (const auto& [key, source] : content.at("sources").items()) report.add("source", source.get<std::string>());
}

void add_tables(const FileQuestion&, const json& content, FileReport& report)
{
    for (const auto& [name, table] : content.items()) {
        if (name.rfind("table", 0) != 0 && name != "beyond_paper") continue;
        for (const auto& [method, row] : table.items()) report.add(name, "{}: {}", method, row.dump());
    }
    for (const char* key : {"commit", "command"})
        if (content.contains(key)) report.add(key, content[key].get<std::string>());
}

void add_motion_report(const FileQuestion&, const json& content, FileReport& report)
{
    report.add("clips", "{}, {} frames", content.at("clips").dump(), content.at("frames").dump());
    report.add("error", "median of the clips {} mm, worst {} mm ({})", content.at("median_error_mm").dump(),
               content.at("worst_error_mm").dump(), content.at("worst_clip").get<std::string>());
}

void add_fit_report(const FileQuestion&, const json& content, FileReport& report)
{
    report.add("scans", "{}, {} fitted, {} pass", content.at("scans").dump(), content.at("fitted").dump(),
               content.at("passed").dump());
}

const JsonKind kinds[] = {
    {{"standard_deviations", "sources"}, "published ranges of motion of our joints", add_joint_limits},
    {{"joints", "description"}, "a joint map: which joints of a motion-capture rig drive ours", add_joint_map},
    {{"format", "clips", "median_error_mm"},
     "how well motions came onto our skeleton (import-motion)",
     add_motion_report},
    {{"scans", "fitted", "reports"}, "how well scans were registered (fit-body)", add_fit_report},
    {{"loads"}, "a scene: what a body meets in a simulation with inertia (simulate-dynamics)"},
    {{"obstacles"}, "a scene: what a body meets in a simulation with inertia (simulate-dynamics)"},
    {{"contact"}, "a scene: what a body meets in a simulation with inertia (simulate-dynamics)"},
    {{"figures"}, "figures of bodies in motion with inertia (report-dynamics)"},
    {{"garments"}, "a scene: what a body meets in a simulation with inertia (simulate-dynamics)"},
    {{"young_normal_pascal"}, "stiffness of an avatar's soft tissue (simulate-dynamics)"},
    {{"young_tangent_pascal"}, "stiffness of an avatar's soft tissue (simulate-dynamics)"},
    {{"thickness"}, "thickness of an avatar's soft tissue at its control points (make-avatar)"},
    {{"architecture", "parts"}, "how the tensors of a network are put together (export-release)"},
    {{"num_poses", "angles"}, "ranges of joint angles that poses take (sample-poses)"},
    {{"table1", "counts", "seconds"}, "tables of a run (evaluate-metrics)", add_tables},
    {{"table1"}, "what the tables of a run must show (check-results)"},
    {{"table3", "counts"}, "how far anatomy sticks out of the skin (measure-protrusion)", add_tables},
};

bool has_all(const json& content, const std::vector<const char*>& members)
{
    return std::all_of(members.begin(), members.end(), [&](const char* key) { return content.contains(key); });
}

/// Files that are told by what their members are.
std::string what_members_are(const json& content)
{
    const auto all = [&](auto is) { return !content.empty() && std::all_of(content.begin(), content.end(), is); };
    if (all([](const json& member) { return member.is_number(); }))
        return "names and numbers, such as seconds of stages";
    if (all([](const json& member) {
            return member.is_object() && member.contains("head") && member.contains("tail");
        }))
        return "bones of a rig of MakeHuman";
    if (all([](const json& member) {
            return member.is_object() && (member.contains("sex") || member.contains("age_years"));
        }))
        return "people: sex and age, for fit-body";
    for (const auto& [key, member] : content.items())  // named like tools
        if (member.is_object() && key.find('-') != std::string::npos) return "options of tools, for --config";
    if (content.contains("weights")) return "weights of a rig of MakeHuman";
    return "JSON of no kind that is known here";
}

}  // namespace

void describe_json(const FileQuestion& file, FileReport& report)
{
    const JsonValue value(file.path);
    const json& content = value.json();
    const auto kind = std::find_if(std::begin(kinds), std::end(kinds),
                                   [&](const JsonKind& candidate) { return has_all(content, candidate.members); });
    report.add("what", kind == std::end(kinds) ? what_members_are(content) : kind->what);
    if (content.contains("description") && content["description"].is_string())
        report.add("description", content["description"].get<std::string>());
    try {
        if (kind != std::end(kinds) && kind->add != nullptr) kind->add(file, content, report);
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: is not what it seems to be ({})", file.path, error.what()));
    }
    std::vector<std::string> members;
    for (const auto& [key, member] : content.items()) members.push_back(key);
    constexpr std::size_t shown = 12;
    const std::size_t more = members.size() > shown ? members.size() - shown : 0;
    members.resize(members.size() - more);
    report.add("members", "{}{}", fmt::join(members, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
}

}  // namespace ndg
