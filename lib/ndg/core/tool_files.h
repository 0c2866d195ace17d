// SPDX-License-Identifier: Apache-2.0
// Private to core: the files that a tool reads and writes, checked before anything is done.
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace ndg {

struct ToolInput {
    std::string flag;  ///< empty: positional
    std::string help;
    std::variant<std::string*, std::vector<std::string>*> paths;
    bool required = true;

    std::string name() const { return flag.empty() ? "FILE" : "--" + flag; }
    std::vector<std::string> list() const;
};

struct ToolOutput {
    std::string flag, help;
    std::string* path = nullptr;
    bool required = true, resumable = false;
};

/// All throw InputError naming flag and file: what is missing, unreadable, a pipe or a device, or has a name that is no
/// text; an output that is there already without `force`, or that is an input.
void check_input(const ToolInput& input);
void check_output(const ToolOutput& output, bool force);
void check_differs(const ToolOutput& output, const ToolInput& input);
/// Makes the folder of an output and sees now, not after hours, whether a file can be made there.
void prepare_output(const ToolOutput& output);

}  // namespace ndg
