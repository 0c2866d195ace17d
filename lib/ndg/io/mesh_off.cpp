// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/text_file.h"
#include "ndg/io/mesh_parts.h"

#include <algorithm>
#include <array>

namespace ndg::mesh {
namespace {

/// Words of the next line that holds any, without comments.
std::vector<std::string_view> next_words(LineReader& lines, const std::string& path)
{
    std::string_view line;
    while (lines.next(line)) {
        auto words = split_words(line.substr(0, line.find('#')));
        if (!words.empty()) return words;
    }
    throw InputError(fmt::format("{}: truncated after line {}", path, lines.number()));
}

}  // namespace

MeshFile read_off(const std::string& path, std::string content, const MeshReading& reading)
{
    const std::string text = normalise_text(path, std::move(content));
    LineReader lines(text);
    const auto where = [&] { return fmt::format("{}: line {}", path, lines.number()); };
    auto words = next_words(lines, path);
    // C and N announce colours and normals, which follow the coordinates.
    const std::array<std::string_view, 4> headers = {"OFF", "COFF", "NOFF", "CNOFF"};
    const bool known = std::any_of(headers.begin(), headers.end(),
                                   [&](std::string_view name) { return equal_without_case(words[0], name); });
    require_input(known, "{}: '{}' is not an OFF header", where(), words[0].substr(0, 20));
    words.erase(words.begin());
    if (words.empty()) words = next_words(lines, path);
    require_input(words.size() >= 2, "{}: the numbers of vertices and faces are missing", where());
    const long long num_vertices = parse_integer(words[0], where());
    const long long num_faces = parse_integer(words[1], where());
    const auto bytes_left = static_cast<long long>(lines.bytes_left());
    // A vertex takes at least "0 0 0", a face at least "3 0 0 0".
    require_input(num_vertices >= 0 && num_faces >= 0 && num_vertices <= bytes_left / 5 && num_faces <= bytes_left / 7,
                  "{}: truncated, {} vertices and {} faces do not fit into {} bytes", where(), num_vertices, num_faces,
                  bytes_left);

    MeshBuilder builder(path, reading.drop_invalid);
    for (long long i = 0; i < num_vertices; ++i) {
        words = next_words(lines, path);
        require_input(words.size() >= 3, "{}: a vertex needs three coordinates, got {}", where(), words.size());
        builder.add_vertex(words.data(), where());
    }
    for (long long i = 0; i < num_faces; ++i) {
        words = next_words(lines, path);
        const long long count = parse_integer(words[0], where());
        require_input(count >= 3 && count < static_cast<long long>(words.size()),
                      "{}: a face of {} vertices, with {} words following", where(), count, words.size() - 1);
        std::vector<long long> corners;
        for (long long k = 1; k <= count; ++k) {
            corners.push_back(parse_integer(words[k], where()));
        }
        builder.add_polygon(corners, "", lines.number());
    }
    return std::move(builder).finish("line", 0);
}

}  // namespace ndg::mesh
