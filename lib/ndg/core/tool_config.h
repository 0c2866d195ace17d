// SPDX-License-Identifier: Apache-2.0
// Private to core: JSON config files.
#pragma once

#include "ndg/core/option_json.h"

#include <string>
#include <vector>

namespace ndg {

/// Sets the options of `tool` from its section of the config file (or leaves them where the file says nothing).
/// `seed_key` names the option that may also stand at the top level; the section's value beats that.
/// Throws InputError naming file, line or key, and the nearest known key for an unknown one.
void apply_config(const std::string& path, const std::string& tool, std::vector<Option>& options,
                  const std::string& seed_key);

}  // namespace ndg
