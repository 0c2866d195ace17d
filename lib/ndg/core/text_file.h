// SPDX-License-Identifier: Apache-2.0
// Text that other programs wrote, in whatever way, as one kind of text; and text that may be shown.
#pragma once

#include <string>
#include <string_view>

namespace ndg {

bool is_utf8(std::string_view bytes);

/// UTF-8 with line feeds: a byte order mark and what old systems put at the end (0x1A, zeros) are left out, lines may
/// end with CR, LF or both, and what is no UTF-8 is taken for Latin-1. Throws InputError, naming `path`, for UTF-16 and
/// UTF-32.
std::string normalise_text(const std::string& path, std::string content);
/// normalise_text of read_file.
std::string read_text_file(const std::string& path);

/// For a terminal: control characters and bytes that are no UTF-8 become '?'.
std::string printable(std::string_view text);

/// Whether two words are the same but for the case of ASCII letters.
bool equal_without_case(std::string_view a, std::string_view b);

}  // namespace ndg
