// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/installed_files.h"

#include <filesystem>

namespace ndg {

std::string installed_path(const std::string& name)
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path executable = fs::read_symlink("/proc/self/exe", error);
    if (error) return "";
    const fs::path path = executable.parent_path().parent_path() / "share/ndg" / name;
    return fs::exists(path, error) ? path.string() : "";
}

}  // namespace ndg
