// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/text_file.h"
#include "ndg/io/mesh_parts.h"

#include <algorithm>

namespace ndg::mesh {
namespace {

/// Vertex of "v", "v/vt", "v//vn" or "v/vt/vn", counted from zero. Negative ones count back from the latest vertex.
long long corner_vertex(std::string_view word, std::size_t num_vertices, const std::string& where)
{
    long long vertex = 0;
    std::size_t begin = 0;
    for (int part = 0; begin <= word.size(); ++part) {
        const std::size_t end = std::min(word.find('/', begin), word.size());
        const std::string_view digits = word.substr(begin, end - begin);
        require_input(part < 3, "{}: '{}' has more than three indices", where, word);
        if (part == 0 || !digits.empty()) {
            const long long index = parse_integer(digits, where);
            require_input(index != 0, "{}: index 0 in '{}', OBJ counts from 1", where, word);
            if (part == 0) vertex = index;
        }
        begin = end + 1;
    }
    if (vertex > 0) return vertex - 1;
    const auto count = static_cast<long long>(num_vertices);
    require_input(vertex >= -count, "{}: vertex {} reaches back beyond the {} vertices so far", where, vertex, count);
    return count + vertex;
}

}  // namespace

MeshFile read_obj(const std::string& path, std::string content, const MeshReading& reading)
{
    MeshBuilder builder(path, reading.drop_invalid);
    const std::string text = normalise_text(path, std::move(content));
    LineReader lines(text);
    std::string group;
    std::string_view line;
    while (lines.next(line)) {
        const std::size_t number = lines.number();
        std::string joined;  // a backslash at the end continues a line
        while (!line.empty() && line.back() == '\\') {
            joined += line.substr(0, line.size() - 1);
            joined += ' ';
            if (!lines.next(line)) line = {};
        }
        if (!joined.empty()) line = joined += line;
        const auto words = split_words(line.substr(0, line.find('#')));
        if (words.empty()) continue;
        const std::string where = words[0] == "v" || words[0] == "f" ? fmt::format("{}: line {}", path, number) : "";
        if (words[0] == "v") {
            require_input(words.size() >= 4, "{}: a vertex needs three coordinates, got {}", where, words.size() - 1);
            builder.add_vertex(&words[1], where);
        } else if (words[0] == "f") {
            require_input(words.size() >= 4, "{}: a face needs three vertices, got {}", where, words.size() - 1);
            std::vector<long long> corners;
            for (std::size_t i = 1; i < words.size(); ++i) {
                corners.push_back(corner_vertex(words[i], builder.num_vertices(), where));
            }
            builder.add_polygon(corners, group, number);
        } else if (words[0] == "g") {
            group.clear();
            for (std::size_t i = 1; i < words.size(); ++i) group += (i > 1 ? " " : "") + std::string(words[i]);
        }
    }
    return std::move(builder).finish("line", 1);
}

}  // namespace ndg::mesh
