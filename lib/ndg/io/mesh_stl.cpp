// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/text_file.h"
#include "ndg/io/mesh_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

namespace ndg::mesh {
namespace {

/// STL repeats every corner; equal ones become one vertex, numbered by first appearance.
class CornerMerger {
public:
    explicit CornerMerger(MeshBuilder& builder) : builder_(builder) {}

    long long vertex(const std::array<float, 3>& position, const std::string& where)
    {
        std::array<float, 3> key = position;
        for (float& coordinate : key) coordinate += 0.0f;  // -0 equals 0
        // Checked before the look-up: NaN has no place in an ordered map.
        for (const float coordinate : key) {
            if (std::isfinite(coordinate)) continue;
            builder_.add_vertex(coordinate, 0, 0, where);  // throws, or is dropped with its triangle
            return static_cast<long long>(builder_.num_vertices()) - 1;
        }
        const auto next = static_cast<long long>(builder_.num_vertices());
        const auto [found, inserted] = vertices_.emplace(key, next);
        if (inserted) builder_.add_vertex(key[0], key[1], key[2], where);
        return found->second;
    }

private:
    MeshBuilder& builder_;
    std::map<std::array<float, 3>, long long> vertices_;
};

constexpr std::size_t header_bytes = 84, triangle_bytes = 50;

MeshFile read_binary(std::string_view content, std::uint32_t num_triangles, MeshBuilder builder)
{
    const std::string path = builder.path();
    CornerMerger merger(builder);
    for (std::uint32_t i = 0; i < num_triangles; ++i) {
        const std::string where = fmt::format("{}: triangle {}", path, i);
        std::vector<long long> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            std::array<float, 3> position{};
            std::memcpy(position.data(), content.data() + header_bytes + triangle_bytes * i + 12 * (k + 1), 12);
            corners.push_back(merger.vertex(position, where));
        }
        builder.add_polygon(corners, "", i);
    }
    return std::move(builder).finish("triangle", 0);
}

MeshFile read_ascii(std::string_view content, MeshBuilder builder)
{
    const std::string path = builder.path();
    const auto parse = builder.drops_invalid() ? parse_number : parse_real;
    CornerMerger merger(builder);
    LineReader lines(content);
    std::string_view line;
    std::vector<long long> corners;
    bool in_solid = false;
    while (lines.next(line)) {
        const auto words = split_words(line);
        if (words.empty()) continue;
        const std::string where = fmt::format("{}: line {}", path, lines.number());
        const auto is = [&](std::string_view word) { return equal_without_case(words[0], word); };
        if (is("vertex")) {
            require_input(words.size() == 4, "{}: a vertex needs three coordinates, got {}", where, words.size() - 1);
            std::array<float, 3> position{};
            for (std::size_t k = 0; k < 3; ++k) position[k] = static_cast<float>(parse(words[k + 1], where));
            corners.push_back(merger.vertex(position, where));
        } else if (is("endloop")) {
            require_input(corners.size() == 3, "{}: a facet of {} vertices, expected 3", where, corners.size());
            builder.add_polygon(corners, "", lines.number());
            corners.clear();
        } else if (is("solid")) {
            in_solid = true;
        } else if (is("endsolid")) {
            require_input(corners.empty(), "{}: the solid ends within a facet", where);
            in_solid = false;
        } else {
            require_input(is("facet") || is("outer") || is("endfacet"), "{}: unknown word '{}'", where,
                          words[0].substr(0, 20));
        }
    }
    require_input(!in_solid && corners.empty(), "{}: truncated, no endsolid before its end at line {}", path,
                  lines.number());
    return std::move(builder).finish("line", 0);
}

/// Binary files may begin with "solid" too, and have bytes after the last triangle; but they hold bytes that no text
/// has.
bool is_text(std::string_view content)
{
    const std::size_t last = content.find_last_not_of(std::string_view("\0\x1A", 2));
    const std::string_view head = content.substr(0, std::min<std::size_t>(last + 1, 512));
    const std::size_t begin = head.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos || !equal_without_case(head.substr(begin, 5), "solid")) return false;
    return std::none_of(head.begin(), head.end(),
                        [](unsigned char c) { return c < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f'; });
}

}  // namespace

MeshFile read_stl(const std::string& path, std::string content, const MeshReading& reading)
{
    MeshBuilder builder(path, reading.drop_invalid);
    std::uint32_t num_triangles = 0;
    if (content.size() >= header_bytes) std::memcpy(&num_triangles, content.data() + 80, 4);
    const std::size_t promised = header_bytes + triangle_bytes * std::size_t{num_triangles};
    const bool exact = content.size() >= header_bytes && content.size() == promised;
    // UTF-16 is no binary format either: normalise_text says so.
    const bool wide = content.compare(0, 2, "\xFF\xFE") == 0 || content.compare(0, 2, "\xFE\xFF") == 0;
    const std::size_t mark = content.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
    if (wide || (!exact && is_text(std::string_view(content).substr(mark))))
        return read_ascii(normalise_text(path, std::move(content)), std::move(builder));
    require_input(content.size() >= promised, "{}: truncated, {} triangles need {} bytes, the file has {}", path,
                  num_triangles, promised, content.size());
    return read_binary(content, num_triangles, std::move(builder));
}

}  // namespace ndg::mesh
