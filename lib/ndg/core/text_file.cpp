// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/text_file.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <algorithm>
#include <cctype>

namespace ndg {
namespace {

unsigned char byte_at(std::string_view text, std::size_t place)
{
    return static_cast<unsigned char>(text[place]);
}

/// Length of the character that begins at `place`, RFC 3629; 0 where there is none.
std::size_t utf8_length(std::string_view text, std::size_t place)
{
    const unsigned char first = byte_at(text, place);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                               : first >= 0xE0 && first < 0xF0 ? 3
                               : first >= 0xF0 && first < 0xF5 ? 4
                                                               : 0;
    if (length == 0 || place + length > text.size()) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte_at(text, place + i) & 0xC0) != 0x80) return 0;
    const unsigned char second = byte_at(text, place + 1);
    const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
    const bool surrogate = first == 0xED && second >= 0xA0, beyond = first == 0xF4 && second >= 0x90;
    return overlong || surrogate || beyond ? 0 : length;
}

/// Name of an encoding in units of more than a byte; empty for others.
std::string wide_encoding(std::string_view text)
{
    const std::string_view start = text.substr(0, 4);
    if (start == std::string_view("\xFF\xFE\0\0", 4) || start == std::string_view("\0\0\xFE\xFF", 4)) return "UTF-32";
    if (start.substr(0, 2) == "\xFF\xFE" || start.substr(0, 2) == "\xFE\xFF") return "UTF-16";
    // Without a mark: every second byte of Latin text is zero.
    const std::size_t looked_at = std::min<std::size_t>(text.size(), 64) / 2 * 2;
    std::size_t zeros[2] = {};
    for (std::size_t i = 0; i < looked_at; ++i) zeros[i % 2] += text[i] == '\0';
    const bool is_wide =
        looked_at >= 8 && std::min(zeros[0], zeros[1]) == 0 && 4 * std::max(zeros[0], zeros[1]) >= looked_at;
    return is_wide ? "UTF-16" : "";
}

}  // namespace

bool is_utf8(std::string_view bytes)
{
    for (std::size_t i = 0; i < bytes.size();) {
        const std::size_t length = utf8_length(bytes, i);
        if (length == 0) return false;
        i += length;
    }
    return true;
}

std::string normalise_text(const std::string& path, std::string content)
{
    const std::string wide = wide_encoding(content);
    require_input(wide.empty(), "{}: is text in {}; save it as UTF-8", path, wide);
    if (content.compare(0, 3, "\xEF\xBB\xBF") == 0) content.erase(0, 3);
    while (!content.empty() && (content.back() == '\x1A' || content.back() == '\0')) content.pop_back();
    const bool latin = !is_utf8(content);
    const bool returns = content.find('\r') != std::string::npos;
    if (!latin && !returns) return content;
    std::string text;
    text.reserve(content.size() + content.size() / 8);
    for (std::size_t i = 0; i < content.size(); ++i) {
        const unsigned char c = byte_at(content, i);
        if (c == '\r') {
            if (i + 1 == content.size() || content[i + 1] != '\n') text += '\n';
        } else if (latin && c >= 0x80) {
            text += static_cast<char>(0xC0 | c >> 6);
            text += static_cast<char>(0x80 | (c & 0x3F));
        } else {
            text += content[i];
        }
    }
    return text;
}

std::string read_text_file(const std::string& path)
{
    return normalise_text(path, read_file(path));
}

std::string printable(std::string_view text)
{
    std::string shown;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = utf8_length(text, i);
        const unsigned char c = byte_at(text, i);
        // U+0080 to U+009F control terminals too.
        const bool control = c < 0x20 || c == 0x7F || (length == 2 && c == 0xC2 && byte_at(text, i + 1) < 0xA0);
        if (length == 0 || control) {
            shown += '?';
        } else {
            shown += text.substr(i, length);
        }
        i += std::max<std::size_t>(length, 1);
    }
    return shown;
}

bool equal_without_case(std::string_view a, std::string_view b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace ndg
