// SPDX-License-Identifier: Apache-2.0
// The file of a page: HTML with the viewer and blocks of numbers, which viewer/src/blocks.js decodes.
#pragma once

#include "ndg/core/types.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace ndg {

/// Positions in 16 bits within `span` metres about an origin of their own frame.
struct Quantiser {
    double span = 1.0;

    /// `points`: N x 3.
    void append(const Eigen::Ref<const Points>& points, const Eigen::RowVector3d& origin,
                std::vector<std::uint16_t>& values) const;
    Points points(const std::vector<std::uint16_t>& values, const Eigen::RowVector3d& origin) const;
};
/// Throws Error where an index does not fit into 16 bits.
std::uint16_t index_value(Eigen::Index index);
/// Vertices of triangles, one after the other.
std::vector<std::uint16_t> triangle_values(const Triangles& triangles);

/// Values as differences (modulo 2^16) from the row before, in the first row from `stride` values before; then all low
/// bytes, all high bytes; then zlib. Neighbours in space and time differ little, so that most high bytes are 0 or 255.
std::string pack_values(const std::vector<std::uint16_t>& values, std::size_t row_length, std::size_t stride);
/// The four byte planes of the values, by zlib.
std::string pack_floats(const std::vector<float>& values);
/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

/// Writes under a temporary name; without commit() nothing is left behind. Blocks stand in the order in which they are
/// written, each in a script element of its own, so that a browser shows what it has while it reads the rest.
class PageWriter {
public:
    /// `head`: JSON text. `title` and `credits` are shown as text where scripts do not run.
    PageWriter(const std::string& path, const std::string& title, const std::string& credits, const std::string& head);
    ~PageWriter();
    PageWriter(const PageWriter&) = delete;
    PageWriter& operator=(const PageWriter&) = delete;

    /// A table of `stride` columns.
    void block(const std::string& name, const std::vector<std::uint16_t>& values, std::size_t stride);
    /// Frames `first_frame`, ... of tables of `stride` columns and `row_length` values each.
    void frames(const std::string& name, int first_frame, const std::vector<std::uint16_t>& values,
                std::size_t row_length, std::size_t stride);
    void frames(const std::string& name, int first_frame, const std::vector<float>& values, std::size_t row_length);
    /// Brings the file to its name. Throws Error where the disk does not take it.
    void commit();

private:
    void script(const std::string& arguments, const std::string& packed);

    std::string path_, temporary_path_;
    std::ofstream stream_;
};

}  // namespace ndg
