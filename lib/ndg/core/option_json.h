// SPDX-License-Identifier: Apache-2.0
// Private to core: values of options from the command line and from JSON, under the same rules, and back to JSON.
#pragma once

#include "ndg/core/options.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace ndg {

nlohmann::json to_json(const Option& option);

/// Sets an option to the value given on the command line. Throws InputError naming flag, value and what is expected.
void set_from_words(Option& option, const std::vector<std::string>& words);
/// `where` names file and section. Throws InputError naming them, key, value and what is expected.
void set_from_json(Option& option, const nlohmann::json& json, const std::string& where);

/// The known name with the smallest edit distance to `name`; empty if `known` is.
std::string nearest_name(const std::string& name, const std::vector<std::string>& known);

}  // namespace ndg
