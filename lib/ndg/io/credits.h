// SPDX-License-Identifier: Apache-2.0
// Licences and credits of the data in a picture or beside a file that has no room for them.
#pragma once

#include <string>

namespace ndg {

/// Puts them into a PNG that is there, as its text "Copyright" (an iTXt chunk, UTF-8); nothing where they are empty.
/// Throws Error where the file is no PNG.
void add_png_credits(const std::string& path, const std::string& credits);

/// Writes <path>.licences.txt, without the place of a number in `path` ("out_{:04}.stl": out_.stl.licences.txt);
/// nothing where they are empty.
void write_credits_beside(const std::string& path, const std::string& credits);

}  // namespace ndg
