// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ndg {

/// A file or folder that comes with the programs ("joint-maps", "joint-limits.json"): in ../share/ndg beside the folder
/// of the running executable, where an installation has the project's configs and a build folder a link to them. Empty
/// where there is none.
std::string installed_path(const std::string& name);

}  // namespace ndg
