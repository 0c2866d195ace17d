// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/info/describers.h"
#include "ndg/io/mesh.h"
#include "ndg/makehuman/files.h"
#include "ndg/scan/scan.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>

namespace ndg {
namespace {

using nlohmann::json;

/// Scans have more; fewer are no person's surface.
constexpr Eigen::Index least_points_of_a_scan = 500;

/// Comments at the beginning of OBJ and PLY files, where our own writers keep licences.
std::string leading_comments(const FileQuestion& file)
{
    std::string comments;
    std::istringstream lines(file.head);
    for (std::string line; std::getline(lines, line);) {
        for (const char* mark : {"# ", "comment "})
            if (line.rfind(mark, 0) == 0) comments += line.substr(std::strlen(mark)) + "\n";
    }
    return comments;
}

/// What a GLB says of itself in its JSON.
void add_gltf(const FileQuestion& file, FileReport& report)
{
    constexpr std::size_t head_bytes = 20;
    std::ifstream stream(file.path, std::ios::binary);
    std::uint32_t length = 0;
    require_input(file.head.size() >= head_bytes, "{}: is cut off", file.path);
    std::memcpy(&length, file.head.data() + 12, sizeof(length));
    std::string text(length, '\0');
    stream.seekg(head_bytes);
    stream.read(text.data(), length);
    const json gltf = json::parse(text, nullptr, false);
    require_input(gltf.is_object(), "{}: its JSON is damaged", file.path);
    const auto count = [&](const char* key) { return gltf.contains(key) ? gltf[key].size() : 0; };
    report.add("glTF", "{} meshes, {} nodes, {} animations", count("meshes"), count("nodes"), count("animations"));
    const json asset = gltf.value("asset", json::object());
    if (asset.contains("generator")) report.add("written by", asset["generator"].get<std::string>());
    if (asset.contains("copyright")) report.add("licences", asset["copyright"].get<std::string>());
}

/// Unit and up axis as a scan of a person would have them.
void add_person(const FileQuestion& file, const MeshFile& mesh, FileReport& report)
{
    if (mesh.vertices.rows() < least_points_of_a_scan) return;
    try {
        ScanOptions options;
        options.max_points = 1000000;  // nearly nothing is thinned
        const ScanPoints scan = prepare_scan(file.path, mesh.vertices, mesh.triangles, options);
        std::vector<std::string> axes;
        for (const Axis axis : scan.up_axes) axes.push_back(to_name(axis));
        const Eigen::RowVector3d size = scan.points.colwise().maxCoeff() - scan.points.colwise().minCoeff();
        report.add("as a person", "unit {}, up {} (guessed), {:.3f} m tall", to_name(scan.unit),
                   fmt::join(axes, " or "), std::abs(size * unit_vector(scan.up_axes.front())));
        for (const std::string& note : scan.notes) report.add("", note);
    } catch (const InputError& error) {
        const std::string message = error.what();
        const std::size_t begin = message.rfind(file.path, 0) == 0 ? file.path.size() + 2 : 0;
        report.add("as a person", "no ({})", message.substr(std::min(begin, message.size())));
    }
}

}  // namespace

void add_box(const Eigen::Ref<const Points>& points, const std::string& unit, FileReport& report)
{
    if (points.rows() == 0) return;
    const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    report.add("box", "{:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}{}", low[0], low[1], low[2], high[0], high[1],
               high[2], unit);
}

void describe_mesh(const FileQuestion& file, FileReport& report)
{
    const MeshFile mesh = read_mesh(file.path);  // always read whole
    const std::set<std::string> groups(mesh.triangle_groups.begin(), mesh.triangle_groups.end());
    report.add("what", mesh.triangles.rows() > 0 ? "a surface" : "a cloud of points");
    report.add("vertices", "{}", mesh.vertices.rows());
    report.add("triangles", "{}", mesh.triangles.rows());
    report.add("groups", "{}", groups.size());
    add_box(mesh.vertices, " in the file's own unit and axes", report);
    add_person(file, mesh, report);
    if (lower_extension(file.path) == ".glb") return add_gltf(file, report);
    const std::string comments = leading_comments(file);
    if (!comments.empty()) report.add("comments", comments);
}

void describe_makehuman_target(const FileQuestion& file, FileReport& report)
{
    const MakeHumanTarget target = read_makehuman_target(file.path, std::numeric_limits<int>::max());
    report.add("what", "a shape target of MakeHuman: displacements of vertices of its base mesh, dm, y up");
    report.add("vertices", "{}", target.vertices.size());
    if (target.offsets.rows() > 0)
        report.add("offsets", "{:.4g} dm on average, {:.4g} at most", target.offsets.rowwise().norm().mean(),
                   target.offsets.rowwise().norm().maxCoeff());
}

}  // namespace ndg
