// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/mesh.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh_parts.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace ndg {
namespace mesh {

LineReader::LineReader(std::string_view text) : text_(text)
{
    const std::size_t end = text.find_first_of("\r\n");
    if (end == std::string_view::npos || text[end] != '\r') return;
    if (end + 1 == text.size() || text[end + 1] != '\n') line_end_ = '\r';
}

bool LineReader::next(std::string_view& line)
{
    if (begin_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find(line_end_, begin_), text_.size());
    line = text_.substr(begin_, end - begin_);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    begin_ = std::min(end + 1, text_.size());
    ++number_;
    return true;
}

std::vector<std::string_view> split_words(std::string_view line)
{
    constexpr std::string_view blanks = " \t\r\n\v\f";
    std::vector<std::string_view> words;
    std::size_t begin = line.find_first_not_of(blanks);
    while (begin != std::string_view::npos) {
        const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        begin = line.find_first_not_of(blanks, end);
    }
    return words;
}

double parse_number(std::string_view word, const std::string& where)
{
    std::string_view digits = word;
    if (digits.size() > 1 && digits.front() == '+') digits.remove_prefix(1);
    double value = 0;
    const auto [last, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool complete = last == digits.data() + digits.size() && !digits.empty();
    // Values below the smallest double round to zero, those above the largest become infinite.
    if (complete && error == std::errc::result_out_of_range) value = std::strtod(std::string(digits).c_str(), nullptr);
    require_input(complete && error != std::errc::invalid_argument, "{}: '{}' is not a number", where, word);
    return value;
}

double parse_real(std::string_view word, const std::string& where)
{
    const double value = parse_number(word, where);
    require_input(std::isfinite(value), "{}: '{}' is not finite", where, word);
    return value;
}

long long parse_integer(std::string_view word, const std::string& where)
{
    long long value = 0;
    const auto [last, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    require_input(error == std::errc() && last == word.data() + word.size() && !word.empty(),
                  "{}: '{}' is not an integer", where, word);
    return value;
}

void MeshBuilder::add_vertex(double x, double y, double z, const std::string& where)
{
    for (const double value : {x, y, z}) {
        require_input(drop_invalid_ || std::isfinite(value), "{}: coordinate {} is not finite", where, value);
    }
    coordinates_.insert(coordinates_.end(), {x, y, z});
}

void MeshBuilder::add_vertex(const std::string_view* words, const std::string& where)
{
    const auto parse = drop_invalid_ ? parse_number : parse_real;
    add_vertex(parse(words[0], where), parse(words[1], where), parse(words[2], where), where);
}

void MeshBuilder::add_polygon(const std::vector<long long>& corners, const std::string& group, std::size_t place)
{
    for (std::size_t i = 2; i < corners.size(); ++i) {
        corners_.insert(corners_.end(), {corners[0], corners[i - 1], corners[i]});
        places_.push_back(place);
        groups_.push_back(group);
    }
}

MeshFile MeshBuilder::finish(const std::string& place_name, int first_index) &&
{
    require_input(!coordinates_.empty(), "{}: holds no vertices", path_);
    constexpr std::size_t most = std::numeric_limits<int>::max() / 3;
    require_input(num_vertices() <= most && places_.size() <= most, "{}: holds more than {} vertices or triangles",
                  path_, most);
    const auto count = static_cast<long long>(num_vertices());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
        require_input(corners_[i] >= 0 && corners_[i] < count, "{}: {} {}: vertex {} is not among the {} vertices",
                      path_, place_name, places_[i / 3], corners_[i] + first_index, count);
    }
    MeshFile mesh;
    mesh.vertices = Eigen::Map<const Points>(coordinates_.data(), static_cast<Eigen::Index>(count), 3);
    mesh.triangles.resize(static_cast<Eigen::Index>(places_.size()), 3);
    std::transform(corners_.begin(), corners_.end(), mesh.triangles.data(),
                   [](long long corner) { return static_cast<int>(corner); });
    mesh.triangle_groups = std::move(groups_);
    if (drop_invalid_ && !mesh.vertices.allFinite()) drop_invalid(mesh);
    return mesh;
}

void MeshBuilder::drop_invalid(MeshFile& mesh) const
{
    std::vector<int> kept, new_index(static_cast<std::size_t>(mesh.vertices.rows()), -1);
    for (int i = 0; i < static_cast<int>(new_index.size()); ++i) {
        if (!mesh.vertices.row(i).allFinite()) continue;
        new_index[i] = static_cast<int>(kept.size());
        kept.push_back(i);
    }
    require_input(!kept.empty(), "{}: none of its {} vertices is a point, all have coordinates that are no numbers",
                  path_, new_index.size());
    mesh.num_dropped = mesh.vertices.rows() - static_cast<Eigen::Index>(kept.size());
    mesh.vertices = mesh.vertices(kept, Eigen::all).eval();
    Eigen::Index count = 0;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const int a = new_index[mesh.triangles(t, 0)], b = new_index[mesh.triangles(t, 1)],
                  c = new_index[mesh.triangles(t, 2)];
        if (a < 0 || b < 0 || c < 0) continue;
        mesh.triangles.row(count) << a, b, c;
        mesh.triangle_groups[count++] = mesh.triangle_groups[t];
    }
    mesh.triangles.conservativeResize(count, 3);
    mesh.triangle_groups.resize(static_cast<std::size_t>(count));
}

}  // namespace mesh

std::string lower_extension(const std::string& path)
{
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

bool is_mesh_name(const std::string& path)
{
    const std::string extension = lower_extension(path);
    return extension == ".obj" || extension == ".ply" || extension == ".off" || extension == ".stl" ||
           extension == ".glb";
}

MeshFile read_mesh(const std::string& path, const MeshReading& reading)
{
    const std::string extension = lower_extension(path);
    require_input(is_mesh_name(path), "{}: unknown mesh format '{}', expected .obj, .ply, .off, .stl or .glb", path,
                  extension);
    std::string content = read_file(path);
    require_input(!content.empty(), "{}: is empty", path);
    if (extension == ".obj") return mesh::read_obj(path, std::move(content), reading);
    if (extension == ".ply") return mesh::read_ply(path, std::move(content), reading);
    if (extension == ".off") return mesh::read_off(path, std::move(content), reading);
    if (extension == ".stl") return mesh::read_stl(path, std::move(content), reading);
    return mesh::read_glb(path, std::move(content), reading);
}

}  // namespace ndg
