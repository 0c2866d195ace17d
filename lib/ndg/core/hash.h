// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace ndg {

/// SHA-256 as 64 lower-case hex digits.
std::string sha256(std::string_view bytes);
/// SHA-256 of a file's content; of a folder: of the sorted relative names and contents of its files.
/// Throws InputError when it cannot be read.
std::string sha256_path(const std::string& path);

}  // namespace ndg
