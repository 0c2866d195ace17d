// SPDX-License-Identifier: Apache-2.0
// Explains a file: what it is, what it holds, in which unit and axes, where it came from, and whether it is whole.
#pragma once

#include "ndg/info/file_report.h"

#include <string>
#include <vector>

namespace ndg {

/// A file, and what is asked about it.
struct FileQuestion {
    std::string path;
    bool check = false;         ///< read everything, with all checksums, and compare the inputs it was made of
    std::string template_path;  ///< of bodies or skins, to measure them; empty: none
    /// The beginning of the file.
    std::string head;

    bool begins_with(std::string_view bytes) const { return head.compare(0, bytes.size(), bytes) == 0; }
};

/// One kind of file. A new kind is a row in describe_file.cpp.
struct FileKind {
    bool (*matches)(const FileQuestion& file);
    void (*describe)(const FileQuestion& file, FileReport& report);
};

/// Throws InputError naming the file and what is wrong with it: of no kind that is known, truncated, damaged, a dataset
/// missing, a number that is not finite.
FileReport describe_file(FileQuestion question);

}  // namespace ndg
