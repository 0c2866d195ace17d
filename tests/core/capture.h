// SPDX-License-Identifier: Apache-2.0
// Runs a Tool in this process as main() would, with both streams caught.
#pragma once

#include "ndg/core/tool.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg::test {

struct ToolRun {
    int exit_code = -1;
    std::string out, err;
};

/// `arguments` without the program name.
ToolRun run_tool(
    Tool& tool, const std::vector<std::string>& arguments, const std::function<void()>& body = [] {});

}  // namespace ndg::test
