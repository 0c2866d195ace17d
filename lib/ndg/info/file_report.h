// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace ndg {

/// What there is to say about a file. Nothing is printed before all is known: of a broken file an error alone is shown.
class FileReport {
public:
    /// A line "label   text"; further lines of the text are indented.
    void add(const std::string& label, const std::string& text);
    template <typename First, typename... Rest>
    void add(const std::string& label, fmt::format_string<First, Rest...> text, First&& first, Rest&&... rest)
    {
        add(label, fmt::format(text, std::forward<First>(first), std::forward<Rest>(rest)...));
    }
    /// Lines as they are.
    void add_block(const std::string& text) { blocks_ += text; }
    /// A gate that does not hold.
    void add_failure(const std::string& text) { failures_.push_back(text); }

    const std::string& rows() const { return rows_; }
    /// The rows, then the blocks.
    std::string text() const { return rows_ + blocks_; }
    const std::vector<std::string>& failures() const { return failures_; }

private:
    std::string rows_, blocks_;
    std::vector<std::string> failures_;
};

}  // namespace ndg
