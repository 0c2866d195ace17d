// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/bodyparts3d.h"

#include "ndg/core/error.h"
#include "ndg/geometry/simplify.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/io/mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

namespace ndg {

const char* const bodyparts3d_licence =
    "Bones and muscles: BodyParts3D, (c) The Database Center for Life Science, licensed under CC Attribution-Share "
    "Alike 2.1 Japan.";

namespace {

constexpr double metres_per_unit = 1e-3;
/// Vertices doubled for their normals have equal coordinates; this only has to be below the finest triangles.
constexpr double merge_distance = 2e-6;
/// Share of the vertices a part gets grows with this power of its area: fingers still get enough for their shape.
constexpr double area_power = 0.65;
constexpr int min_vertices = 40;

struct PartFile {
    std::string path;
    BodyPartName name;
    AnatomyLayer layer = AnatomyLayer::bone;
};

bool is_bone_name(const std::string& name)
{
    return name == "Manubrium" || name == "Body of sternum" || name == "Atlas" || name == "Axis";
}

std::vector<PartFile> list_files(const std::string& folder)
{
    namespace fs = std::filesystem;
    std::vector<PartFile> files;
    for (const char* group : {"bones", "muscles", "other", "tendons"}) {
        const fs::path path = fs::path(folder) / group;
        require_input(fs::is_directory(path), "{}: has no folder '{}'", folder, group);
        for (const auto& entry : fs::directory_iterator(path)) {
            if (entry.path().extension() != ".glb") continue;
            PartFile file;
            file.path = entry.path().string();
            try {
                file.name = parse_body_part_name(entry.path().filename().string());
            } catch (const InputError& error) {
                throw InputError(fmt::format("{}: {}", path.string(), error.what()));
            }
            file.layer = std::string(group) == "bones" || is_bone_name(file.name.name) ? AnatomyLayer::bone
                                                                                       : AnatomyLayer::muscle;
            files.push_back(std::move(file));
        }
    }
    require_input(!files.empty(), "{}: holds no .glb files", folder);
    std::sort(files.begin(), files.end(), [](const PartFile& a, const PartFile& b) {
        return std::tie(a.layer, a.name.name, a.path) < std::tie(b.layer, b.name.name, b.path);
    });
    return files;
}

AnatomyMesh read_part(const PartFile& file)
{
    MeshReading stored;
    stored.placed = false;  // its nodes turn parts to y up, and metres_per_unit is of what is stored
    const MeshFile mesh = read_mesh(file.path, stored);
    AnatomyMesh part;
    part.name = file.name.name;
    part.fma_id = file.name.fma_id;
    part.side = file.name.side;
    part.layer = file.layer;
    try {
        TriangleMesh closed = repair_closed(metres_per_unit * mesh.vertices, mesh.triangles, merge_distance);
        part.vertices = std::move(closed.vertices);
        part.triangles = std::move(closed.triangles);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", file.path, error.what()));
    }
    return part;
}

/// Calls `work(i)` for all parts on all cores and rethrows the error of the first part that failed.
template <typename Work>
void for_each_part(std::size_t count, const Work& work)
{
    std::vector<std::exception_ptr> errors(count);
#pragma omp parallel for schedule(dynamic, 1)
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(count); ++i) {
        try {
            work(static_cast<std::size_t>(i));
        } catch (...) {
            errors[i] = std::current_exception();
        }
    }
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
}

/// Target vertices of each part of one layer, so that they add up to `total`.
void share_vertices(const std::vector<AnatomyMesh>& parts, AnatomyLayer layer, int total, std::vector<int>& targets)
{
    std::vector<double> wishes(parts.size(), 0.0);
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (parts[i].layer == layer)
            wishes[i] = std::pow(triangle_areas(parts[i].vertices, parts[i].triangles).sum(), area_power);
    const auto target = [&](std::size_t i, double scale) {
        const int wished = std::max(min_vertices, static_cast<int>(std::lround(scale * wishes[i])));
        return std::min(wished, static_cast<int>(parts[i].vertices.rows()));
    };
    double low = 0.0, high = 1e9;
    for (int step = 0; step < 80; ++step) {
        const double middle = 0.5 * (low + high);
        long sum = 0;
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (parts[i].layer == layer) sum += target(i, middle);
        (sum < total ? low : high) = middle;
    }
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (parts[i].layer == layer) targets[i] = target(i, low);
}

/// Moves all parts sideways so that paired bones mirror each other in x = 0.
void centre_sideways(std::vector<AnatomyMesh>& parts)
{
    std::map<std::string, std::map<BodySide, double>> middles;
    for (const AnatomyMesh& part : parts) {
        if (part.layer != AnatomyLayer::bone || part.side == BodySide::middle) continue;
        std::string key = part.name;
        for (char& c : key) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        const std::string side = to_name(part.side);
        key.replace(key.find(side), side.size(), "*");
        middles[key][part.side] = 0.5 * (part.vertices.col(0).minCoeff() + part.vertices.col(0).maxCoeff());
    }
    std::vector<double> offsets;
    for (const auto& [unused, sides] : middles)
        if (sides.size() == 2) offsets.push_back(0.5 * (sides.at(BodySide::left) + sides.at(BodySide::right)));
    if (offsets.empty()) return;
    std::nth_element(offsets.begin(), offsets.begin() + std::ptrdiff_t(offsets.size() / 2), offsets.end());
    for (AnatomyMesh& part : parts) part.vertices.col(0).array() -= offsets[offsets.size() / 2];
}

}  // namespace

BodyPartName parse_body_part_name(const std::string& file_name)
{
    static const std::regex pattern("FJ[0-9]+_BP[0-9]+_FMA([0-9]{1,9})_(.+)\\.glb");
    std::smatch match;
    require_input(std::regex_match(file_name, match, pattern),
                  "the file name '{}' is not of the form FJ<n>_BP<n>_FMA<id>_<name>.glb", file_name);
    BodyPartName result;
    result.fma_id = std::stoi(match[1].str());
    result.name = match[2].str();
    std::replace(result.name.begin(), result.name.end(), '_', ' ');
    std::string word;
    for (const char c : result.name + " ") {
        if (c != ' ') {
            word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            continue;
        }
        for (const BodySide side : {BodySide::left, BodySide::right}) {
            if (word == to_name(side)) result.side = side;
        }
        word.clear();
    }
    return result;
}

std::vector<AnatomyMesh> read_bodyparts3d(const std::string& folder, const BodyParts3DOptions& options)
{
    require_input(options.bone_vertices > 0 && options.muscle_vertices > 0,
                  "the numbers of bone and muscle vertices, {} and {}, are not positive", options.bone_vertices,
                  options.muscle_vertices);
    const std::vector<PartFile> files = list_files(folder);
    std::vector<AnatomyMesh> parts(files.size());
    for_each_part(files.size(), [&](std::size_t i) { parts[i] = read_part(files[i]); });
    std::vector<int> targets(parts.size(), min_vertices);
    share_vertices(parts, AnatomyLayer::bone, options.bone_vertices, targets);
    share_vertices(parts, AnatomyLayer::muscle, options.muscle_vertices, targets);
    for_each_part(files.size(), [&](std::size_t i) {
        TriangleMesh mesh = simplify_closed({parts[i].vertices, parts[i].triangles}, targets[i]);
        parts[i].vertices = std::move(mesh.vertices);
        parts[i].triangles = std::move(mesh.triangles);
    });
    centre_sideways(parts);
    return parts;
}

}  // namespace ndg
