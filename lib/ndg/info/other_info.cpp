// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/info/describers.h"

#include <cstdint>
#include <cstring>
#include <filesystem>

namespace ndg {
namespace {

/// Numbers of a PNG: the most significant byte first.
std::uint32_t big_endian_at(const std::string& bytes, std::size_t at)
{
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = (value << 8) | static_cast<unsigned char>(bytes[at + i]);
    return value;
}

template <typename T>
T value_at(const std::string& bytes, std::size_t at)
{
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

}  // namespace

void describe_picture(const FileQuestion& file, FileReport& report)
{
    const std::string bytes = read_file(file.path);
    require_input(bytes.size() > 45 && bytes.compare(bytes.size() - 8, 4, "IEND") == 0, "{}: is cut off", file.path);
    report.add("what", "a picture, PNG");
    report.add("size", "{} x {} pixels", big_endian_at(bytes, 16), big_endian_at(bytes, 20));
}

void describe_point_cache(const FileQuestion& file, FileReport& report)
{
    constexpr std::size_t head_bytes = 32;
    require_input(file.head.size() >= head_bytes, "{}: is cut off", file.path);
    const auto vertices = value_at<std::int32_t>(file.head, 16), frames = value_at<std::int32_t>(file.head, 28);
    require_input(vertices >= 0 && frames >= 0, "{}: announces {} vertices and {} frames", file.path, vertices, frames);
    const std::uintmax_t expected = head_bytes + std::uintmax_t(12) * std::uintmax_t(vertices) * std::uintmax_t(frames);
    const std::uintmax_t found = std::filesystem::file_size(file.path);
    require_input(found == expected, "{}: has {} bytes where {} frames of {} vertices need {}", file.path, found,
                  frames, vertices, expected);
    report.add("what", "a point cache (PC2): the vertices of a mesh, frame by frame; the .obj of its name is the mesh");
    report.add("frames", "{} of {} vertices", frames, vertices);
}

void describe_page(const FileQuestion& file, FileReport& report)
{
    const std::string page = read_file(file.path);
    require_input(page.rfind("</html>") != std::string::npos, "{}: is cut off", file.path);
    const bool moves = page.find("Viewer of Neural Deformation Gradients") != std::string::npos;
    report.add("what", moves ? "a page that shows a body in motion (docs/viewer.md)" : "a page of HTML, a report");
    const std::size_t begin = page.find("<title>"), end = page.find("</title>");
    if (begin < end) report.add("title", page.substr(begin + 7, end - begin - 7));
    const std::size_t licences = page.find("<pre>"), licences_end = page.find("</pre>");
    if (moves && licences < licences_end && licences_end - licences > 6)
        report.add("licences", page.substr(licences + 5, licences_end - licences - 5));
    report.add("size", "{:.1f} MB", 1e-6 * double(page.size()));
}

void describe_markdown(const FileQuestion& file, FileReport& report)
{
    report.add("what", "a text for people, Markdown");
    report.add("title", file.head.substr(0, file.head.find('\n')));
}

}  // namespace ndg
