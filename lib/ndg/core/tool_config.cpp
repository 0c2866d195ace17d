// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool_config.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"

#include <nlohmann/json.hpp>

#include "ndg_tool_names.h"  // made by CMake from tools/CMakeLists.txt

#include <algorithm>

namespace ndg {
namespace {

using nlohmann::json;

/// One config file serves a whole pipeline: every tool knows the names of the others' sections.
const std::vector<std::string> tool_names = {NDG_TOOL_NAMES};

}  // namespace

void apply_config(const std::string& path, const std::string& tool, std::vector<Option>& options,
                  const std::string& seed_key)
{
    const JsonValue file(path);
    const json& config = file.json();
    require_input(config.is_object(), "{}: expected a JSON object with one section a tool, got {}", path,
                  config.type_name());

    std::vector<std::string> known_sections = tool_names;
    known_sections.insert(known_sections.end(), {tool, "description", seed_key});
    std::vector<std::string> known_keys;
    for (const Option& option : options) known_keys.push_back(option.key());
    const auto find = [&](const std::string& key) {
        return std::find_if(options.begin(), options.end(), [&](const Option& option) { return option.key() == key; });
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
    if (config.contains(seed_key)) set_from_json(*find(seed_key), config[seed_key], path + ": (top level)");
    if (!config.contains(tool)) return;
    for (const auto& [key, value] : config[tool].items()) {
        const auto option = find(key);
        require_input(option != options.end(), "{}: unknown key \"{}\" in section \"{}\", did you mean \"{}\"?", path,
                      key, tool, nearest_name(key, known_keys));
        set_from_json(*option, value, path + ": " + tool);
    }
}

}  // namespace ndg
