// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/project_files.h"

#include <filesystem>

namespace ndg {

std::string find_project_config(const std::string& name)
{
    namespace fs = std::filesystem;
    constexpr int num_levels = 4;  // build/release/bin/animate lies three below the source tree
    std::error_code error;
    fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
    for (int level = 0; level < num_levels && !folder.empty(); ++level, folder = folder.parent_path())
        for (const char* below : {"configs", "share/neural_deformation_gradients/configs"})
            if (const fs::path path = folder / below / name; fs::exists(path, error)) return path.string();
    return "";
}

}  // namespace ndg
