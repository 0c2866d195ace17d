// SPDX-License-Identifier: Apache-2.0
// Private to io: what the mesh formats share.
#pragma once

#include "ndg/io/mesh.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ndg::mesh {

/// Lines of a text with their numbers, without line ends; trailing blanks and empty lines stay. They end with LF or CR
/// LF or, where the first one does, with CR alone.
class LineReader {
public:
    explicit LineReader(std::string_view text);
    /// False at the end.
    bool next(std::string_view& line);
    /// Number of the line read last, from 1.
    std::size_t number() const { return number_; }
    std::size_t bytes_left() const { return text_.size() - begin_; }

private:
    std::string_view text_;
    char line_end_ = '\n';
    std::size_t begin_ = 0, number_ = 0;
};

/// Words between blanks.
std::vector<std::string_view> split_words(std::string_view line);

/// A number (parse_real: a finite one) or an integer; `where` starts the InputError ("mesh.obj: line 3").
double parse_number(std::string_view word, const std::string& where);
double parse_real(std::string_view word, const std::string& where);
long long parse_integer(std::string_view word, const std::string& where);

/// Collects vertices and polygons, then checks them.
class MeshBuilder {
public:
    /// `drop_invalid`: see MeshReading.
    explicit MeshBuilder(std::string path, bool drop_invalid = false)
        : path_(std::move(path)), drop_invalid_(drop_invalid)
    {
    }

    const std::string& path() const { return path_; }
    bool drops_invalid() const { return drop_invalid_; }
    std::size_t num_vertices() const { return coordinates_.size() / 3; }
    /// Throws InputError, starting with `where`, unless finite, where such are not dropped in finish().
    void add_vertex(double x, double y, double z, const std::string& where);
    /// Of the first three words.
    void add_vertex(const std::string_view* words, const std::string& where);
    /// Splits the polygon into a fan. `corners` are checked in finish(), since OBJ may name vertices before they come;
    /// `place` ("line 7", "face 3") is kept for the message.
    void add_polygon(const std::vector<long long>& corners, const std::string& group, std::size_t place);
    /// `place_name`: what `place` counts; `first_index`: 1 for formats that count vertices from one.
    MeshFile finish(const std::string& place_name, int first_index) &&;

private:
    /// Takes out points that are not finite and the triangles at them.
    void drop_invalid(MeshFile& mesh) const;

    std::string path_;
    bool drop_invalid_;
    std::vector<double> coordinates_;
    std::vector<long long> corners_;
    std::vector<std::size_t> places_;
    std::vector<std::string> groups_;
};

MeshFile read_obj(const std::string& path, std::string content, const MeshReading& reading);
MeshFile read_ply(const std::string& path, std::string content, const MeshReading& reading);
MeshFile read_off(const std::string& path, std::string content, const MeshReading& reading);
MeshFile read_stl(const std::string& path, std::string content, const MeshReading& reading);
MeshFile read_glb(const std::string& path, std::string content, const MeshReading& reading);

}  // namespace ndg::mesh
