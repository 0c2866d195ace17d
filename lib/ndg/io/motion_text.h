// SPDX-License-Identifier: Apache-2.0
// Words and lines of a motion text file, with line numbers for error messages.
#pragma once

#include <Eigen/Core>

#include <string>
#include <string_view>
#include <vector>

namespace ndg {

/// A whole text file, read word by word or line by line. Throws InputError naming file and line.
class MotionText {
public:
    explicit MotionText(const std::string& path);

    /// Next word across lines; empty at the end of the file.
    std::string_view next_word();
    /// What is left of the current line if any word is left, else the next line that is not blank; empty at the end.
    std::vector<std::string_view> next_line();
    /// As next_word, but the end of the file is an InputError; `expected` says what should stand there.
    std::string_view need_word(std::string_view expected);
    /// The next word as a finite number; `what` names it in messages.
    double need_number(std::string_view what);
    /// A word as a finite number.
    double number(std::string_view word, std::string_view what) const;
    /// InputError with file, line and `message`.
    [[noreturn]] void fail(const std::string& message) const;

    const std::string& path() const { return path_; }
    int line() const { return line_; }

private:
    std::string path_;
    std::string text_;
    std::size_t position_ = 0;
    int line_ = 1;
};

/// Rotation by `angle` radians about axis 'x', 'y' or 'z'.
Eigen::Matrix3d axis_rotation(char axis, double angle);

/// File name without folder and extension.
std::string file_stem(const std::string& path);

}  // namespace ndg
