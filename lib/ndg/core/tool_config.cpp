// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool_config.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {
namespace {

using nlohmann::json;

/// One config file serves a whole pipeline: every tool knows the names of the others' sections.
const std::vector<std::string> tool_names = {
    "make-template", "sample-bodies", "fit-body",         "build-layers",    "fit-shape-space", "import-motion",
    "sample-poses",  "make-splits",   "simulate-fem",     "collect-samples", "train-ndg",       "infer-ndg",
    "reconstruct",   "animate",       "evaluate-metrics", "export-scene",    "ndg-info"};

}  // namespace

void apply_config(const std::string& path, const std::string& tool, std::vector<ToolParameter>& parameters,
                  const std::string& seed_key)
{
    const JsonValue file(path);
    const json& config = file.json();
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
