// SPDX-License-Identifier: Apache-2.0
#include "ndg/page/page_blocks.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/markup.h"
#include "ndg/page/viewer_bundle.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

std::string deflated(const std::string& bytes)
{
    uLongf size = compressBound(uLong(bytes.size()));
    std::string packed(size, '\0');
    const int status = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                                 reinterpret_cast<const Bytef*>(bytes.data()), uLong(bytes.size()), 9);
    require(status == Z_OK, "zlib could not compress {} bytes (status {})", bytes.size(), status);
    packed.resize(size);
    return packed;
}

/// JSON inside of a script element: "</script" must not occur.
std::string script_json(const std::string& json)
{
    std::string escaped;
    for (const char c : json) escaped += c == '<' ? "\\u003c" : std::string(1, c);
    return escaped;
}

}  // namespace

void Quantiser::append(const Eigen::Ref<const Points>& points, const Eigen::RowVector3d& origin,
                       std::vector<std::uint16_t>& values) const
{
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int k = 0; k < 3; ++k) {
            const double unit = ((points(i, k) - origin[k]) / span + 1.0) / 2.0;
            values.push_back(std::uint16_t(std::lround(65535.0 * std::clamp(unit, 0.0, 1.0))));
        }
}

Points Quantiser::points(const std::vector<std::uint16_t>& values, const Eigen::RowVector3d& origin) const
{
    Points result(Eigen::Index(values.size() / 3), 3);
    for (Eigen::Index i = 0; i < result.size(); ++i)
        result.data()[i] = (2.0 * values[i] / 65535.0 - 1.0) * span + origin[i % 3];
    return result;
}

std::uint16_t index_value(Eigen::Index index)
{
    require(index >= 0 && index < 65536, "index {} does not fit the 16 bits of a page", index);
    return std::uint16_t(index);
}

std::vector<std::uint16_t> triangle_values(const Triangles& triangles)
{
    std::vector<std::uint16_t> values;
    values.reserve(std::size_t(triangles.size()));
    for (Eigen::Index i = 0; i < triangles.size(); ++i) values.push_back(index_value(triangles.data()[i]));
    return values;
}

std::string pack_values(const std::vector<std::uint16_t>& values, std::size_t row_length, std::size_t stride)
{
    std::string planes(2 * values.size(), '\0');
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::uint16_t before = i >= row_length ? values[i - row_length] : i >= stride ? values[i - stride] : 0;
        const auto difference = std::uint16_t(values[i] - before);
        planes[i] = char(difference & 0xff);
        planes[values.size() + i] = char(difference >> 8);
    }
    return deflated(planes);
}

std::string pack_floats(const std::vector<float>& values)
{
    std::string planes(4 * values.size(), '\0');
    const auto* bytes = reinterpret_cast<const char*>(values.data());
    for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t k = 0; k < 4; ++k) planes[k * values.size() + i] = bytes[4 * i + k];
    return deflated(planes);
}

std::string base64(std::string_view bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

PageWriter::PageWriter(const std::string& path, const std::string& title, const std::string& credits,
                       const std::string& head)
    : path_(path), temporary_path_(temporary_name(path)), stream_(temporary_path_, std::ios::binary)
{
    stream_ << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            << "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            << "<title>" << escaped_markup(title) << "</title>\n<link rel=\"icon\" href=\"data:,\">\n</head>\n<body>\n"
            << "<noscript><p>This page shows a body in motion and needs JavaScript.</p><pre>" << escaped_markup(credits)
            << "</pre></noscript>\n<script>\n"
            << viewer_bundle() << "\n</script>\n<script>NdgViewer.open(" << script_json(head) << ")</script>\n";
}

PageWriter::~PageWriter()
{
    if (!temporary_path_.empty()) ::unlink(temporary_path_.c_str());
}

void PageWriter::script(const std::string& arguments, const std::string& packed)
{
    stream_ << "<script>NdgViewer.add({" << arguments << ",data:\"" << base64(packed) << "\"})</script>\n";
}

void PageWriter::block(const std::string& name, const std::vector<std::uint16_t>& values, std::size_t stride)
{
    script(fmt::format("name:\"{}\",count:{},stride:{}", name, values.size(), stride),
           pack_values(values, values.size(), stride));
}

void PageWriter::frames(const std::string& name, int first_frame, const std::vector<std::uint16_t>& values,
                        std::size_t row_length, std::size_t stride)
{
    script(fmt::format("name:\"{}\",frame:{},count:{},row:{},stride:{}", name, first_frame, values.size(), row_length,
                       stride),
           pack_values(values, row_length, stride));
}

void PageWriter::frames(const std::string& name, int first_frame, const std::vector<float>& values,
                        std::size_t row_length)
{
    script(fmt::format("name:\"{}\",frame:{},count:{},row:{},floats:1", name, first_frame, values.size(), row_length),
           pack_floats(values));
}

void PageWriter::commit()
{
    stream_ << "<script>NdgViewer.end()</script>\n</body>\n</html>\n";
    stream_.close();
    require(stream_.good(), "{}: cannot write {}", path_, temporary_path_);
    replace_file(temporary_path_, path_);
    temporary_path_.clear();
}

}  // namespace ndg
