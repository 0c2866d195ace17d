// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool_config.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <algorithm>
#include <set>

namespace ndg {
namespace {

using nlohmann::json;

/// One config file serves a whole pipeline: every tool knows the names of the others' sections.
const std::vector<std::string> tool_names = {
    "make-template", "sample-bodies", "fit-body",         "build-layers",    "fit-shape-space", "import-motion",
    "sample-poses",  "make-splits",   "simulate-fem",     "collect-samples", "train-ndg",       "infer-ndg",
    "reconstruct",   "animate",       "evaluate-metrics", "export-scene",    "ndg-info"};

json parse_config(const std::string& path)
{
    const std::string text = read_file(path);
    // The library keeps the last of equal keys; a value silently lost is an error here.
    std::vector<std::set<std::string>> open_objects;
    const auto check_keys = [&](int, json::parse_event_t event, json& value) {
        if (event == json::parse_event_t::object_start) open_objects.emplace_back();
        if (event == json::parse_event_t::object_end) open_objects.pop_back();
        if (event == json::parse_event_t::key) {
            const auto key = value.get<std::string>();
            require_input(open_objects.back().insert(key).second, "{}: key \"{}\" stands twice in the same object",
                          path, key);
        }
        return true;
    };
    try {
        return json::parse(text, check_keys);
    } catch (const json::parse_error& error) {
        const std::size_t end = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
        throw InputError(fmt::format("{}: line {}: not valid JSON", path, line));
    }
}

}  // namespace

void apply_config(const std::string& path, const std::string& tool, std::vector<ToolParameter>& parameters,
                  const std::string& seed_key)
{
    const json config = parse_config(path);
    require_input(config.is_object(), "{}: expected a JSON object with one section a tool, got {}", path,
                  config.type_name());

    std::vector<std::string> known_sections = tool_names;
    known_sections.insert(known_sections.end(), {tool, "description", seed_key});
    std::vector<std::string> known_keys;
    for (const ToolParameter& parameter : parameters) known_keys.push_back(parameter.key());
    const auto find = [&](const std::string& key) {
        return std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.key() == key; });
    };

    for (const auto& [section, content] : config.items()) {
        const bool known = std::find(known_sections.begin(), known_sections.end(), section) != known_sections.end();
        require_input(known, "{}: unknown section \"{}\", did you mean \"{}\"?", path, section,
                      nearest_name(section, known_sections));
        if (section == "description") {
            require_input(content.is_string(), "{}: description: expected a text, got {}", path, content.dump());
        } else if (section != seed_key) {
            require_input(content.is_object(), "{}: section \"{}\": expected an object, got {}", path, section,
                          content.dump());
        }
    }
    if (config.contains(seed_key)) find(seed_key)->take_json(config[seed_key], path + ": (top level)");
    if (!config.contains(tool)) return;
    for (const auto& [key, value] : config[tool].items()) {
        const auto parameter = find(key);
        require_input(parameter != parameters.end(), "{}: unknown key \"{}\" in section \"{}\", did you mean \"{}\"?",
                      path, key, tool, nearest_name(key, known_keys));
        parameter->take_json(value, path + ": " + tool);
    }
}

}  // namespace ndg
