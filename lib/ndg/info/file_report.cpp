// SPDX-License-Identifier: Apache-2.0
#include "ndg/info/file_report.h"

namespace ndg {

void FileReport::add(const std::string& label, const std::string& text)
{
    constexpr int width = 12;
    std::string indented = text;
    while (!indented.empty() && indented.back() == '\n') indented.pop_back();
    for (std::size_t at = 0; (at = indented.find('\n', at)) != std::string::npos; at += width + 2)
        indented.replace(at, 1, "\n" + std::string(width + 1, ' '));
    rows_ += fmt::format("{:<{}} {}\n", label, width, indented);
}

}  // namespace ndg
