// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/mesh_parts.h"

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
            require_input(std::isfinite(coordinate), "{}: coordinate {} is not finite", where, coordinate);
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

MeshFile read_binary(const std::string& path, std::string_view content, std::uint32_t num_triangles)
{
    MeshBuilder builder(path);
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

MeshFile read_ascii(const std::string& path, std::string_view content)
{
    MeshBuilder builder(path);
    CornerMerger merger(builder);
    LineReader lines(content);
    std::string_view line;
    std::vector<long long> corners;
    bool in_solid = false;
    while (lines.next(line)) {
        const auto words = split_words(line);
        if (words.empty()) continue;
        const std::string where = fmt::format("{}: line {}", path, lines.number());
        if (words[0] == "vertex") {
            require_input(words.size() == 4, "{}: a vertex needs three coordinates, got {}", where, words.size() - 1);
            std::array<float, 3> position{};
            for (std::size_t k = 0; k < 3; ++k) position[k] = static_cast<float>(parse_real(words[k + 1], where));
            corners.push_back(merger.vertex(position, where));
        } else if (words[0] == "endloop") {
            require_input(corners.size() == 3, "{}: a facet of {} vertices, expected 3", where, corners.size());
            builder.add_polygon(corners, "", lines.number());
            corners.clear();
        } else if (words[0] == "solid") {
            in_solid = true;
        } else if (words[0] == "endsolid") {
            require_input(corners.empty(), "{}: the solid ends within a facet", where);
            in_solid = false;
        } else {
            require_input(words[0] == "facet" || words[0] == "outer" || words[0] == "endfacet", "{}: unknown word '{}'",
                          where, words[0].substr(0, 20));
        }
    }
    require_input(!in_solid && corners.empty(), "{}: truncated, no endsolid before its end at line {}", path,
                  lines.number());
    return std::move(builder).finish("line", 0);
}

}  // namespace

MeshFile read_stl(const std::string& path, std::string_view content)
{
    std::uint32_t num_triangles = 0;
    if (content.size() >= header_bytes) std::memcpy(&num_triangles, content.data() + 80, 4);
    const std::size_t promised = header_bytes + triangle_bytes * std::size_t{num_triangles};
    // Some binary files begin with "solid" too; the exact size tells them from text.
    if (content.size() >= header_bytes && content.size() == promised) return read_binary(path, content, num_triangles);
    if (content.substr(0, 5) == "solid") return read_ascii(path, content);
    require_input(content.size() >= promised, "{}: truncated, {} triangles need {} bytes, the file has {}", path,
                  num_triangles, promised, content.size());
    return read_binary(path, content, num_triangles);
}

}  // namespace ndg::mesh
