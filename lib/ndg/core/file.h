// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ndg {

/// Whole content of a file. Throws InputError when it is missing, a folder, a pipe or device, or unreadable.
std::string read_file(const std::string& path);
/// Writes through a temporary name: a reader, or a crash, sees the old content or the new one. Throws Error.
void write_file(const std::string& path, std::string_view content);

/// Where what is written to `path` goes: where links lead, the path itself otherwise; the file need not exist. Throws
/// InputError for what is there and is no regular file (a folder, a pipe, a device) and for links in a circle.
std::string writing_path(const std::string& path);

/// Names of files 0 to count - 1: `pattern` holds the place of the number as "{}" or, with leading zeros, "{:04}".
/// Throws InputError where that is malformed.
std::vector<std::string> numbered_names(const std::string& pattern, int count);

/// writing_path and ".<pid>.tmp".
std::string temporary_name(const std::string& path);
/// Brings a finished temporary file to disk and renames it to writing_path. Throws Error; the temporary file stays
/// then.
void replace_file(const std::string& temporary_path, const std::string& path);

}  // namespace ndg
