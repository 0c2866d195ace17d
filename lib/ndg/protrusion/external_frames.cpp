// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/external_frames.h"

#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/core/text_file.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/io/mesh.h"

#include <filesystem>
#include <map>
#include <sstream>
#include <vector>

namespace ndg {

namespace {

struct FramePaths {
    std::string skin;
    std::map<std::string, std::string> tissues;  ///< name -> path
};

/// By frame: what stands between the last underscore and the extension.
std::map<std::string, FramePaths> list_frames(const std::string& folder)
{
    std::map<std::string, FramePaths> frames;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string path = entry.path().string(), stem = entry.path().stem().string();
        if (!is_mesh_name(path)) continue;
        const std::size_t underscore = stem.rfind('_');
        require_input(underscore != std::string::npos && underscore > 0,
                      "{}: a mesh of a frame is called <tissue>_<frame>, one tissue of which is skin", path);
        const std::string tissue = stem.substr(0, underscore);
        FramePaths& frame = frames[stem.substr(underscore + 1)];
        (tissue == "skin" ? frame.skin : frame.tissues[tissue]) = path;
    }
    require_input(!frames.empty(), "{}: there are no meshes called <tissue>_<frame> in it", folder);
    for (const auto& [name, frame] : frames) {
        require_input(!frame.skin.empty(), "{}: frame {} has no skin_{}", folder, name, name);
        require_input(!frame.tissues.empty(), "{}: frame {} has a skin and nothing inside of it", folder, name);
    }
    return frames;
}

std::vector<int> read_excluded(const std::string& path)
{
    std::vector<int> vertices;
    if (!std::filesystem::exists(path)) return vertices;
    std::istringstream text(read_text_file(path));
    std::string word;
    while (text >> word) {
        std::size_t used = 0;
        int vertex = -1;
        try {
            vertex = std::stoi(word, &used);
        } catch (const std::exception&) {
        }
        require_input(used == word.size() && vertex >= 0, "{}: '{}' is no index of a vertex", path, word);
        vertices.push_back(vertex);
    }
    return vertices;
}

bool touches(const Eigen::RowVector3i& triangle, const std::vector<char>& marked)
{
    return marked[triangle[0]] || marked[triangle[1]] || marked[triangle[2]];
}

/// Triangles of which no vertex is marked.
Triangles without(const Triangles& triangles, const std::vector<char>& marked)
{
    Triangles kept(triangles.rows(), 3);
    Eigen::Index count = 0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        if (!touches(triangles.row(t), marked)) kept.row(count++) = triangles.row(t);
    return kept.topRows(count);
}

}  // namespace

ProtrusionRow external_protrusion(const std::string& method, const std::string& folder)
{
    const std::string excluded_path = folder + "/excluded.txt";
    const std::vector<int> excluded = read_excluded(excluded_path);
    const std::map<std::string, FramePaths> frames = list_frames(folder);
    ProtrusionSum sum(method);
    Progress progress("protrusion of " + method, frames.size());
    for (const auto& [name, paths] : frames) {
        const MeshFile file = read_mesh(paths.skin);
        const std::string defect = closed_surface_defect(file.vertices, file.triangles);
        require_input(defect.empty(), "{}: {}", paths.skin, defect);
        std::vector<char> left_out(file.vertices.rows(), 0);
        for (const int v : excluded) {
            require_input(v < file.vertices.rows(), "{}: vertex {}, where {} has {}", excluded_path, v, paths.skin,
                          file.vertices.rows());
            left_out[v] = 1;
        }
        FrameSkin skin = {file.vertices, file.triangles, {}};
        for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
            skin.compared.push_back(!touches(skin.triangles.row(t), left_out));
        const TriangleTree surface(skin.vertices, skin.triangles);

        FrameProtrusion frame;
        std::string deepest;
        std::set<std::string> intersecting;
        for (const auto& [tissue, path] : paths.tissues) {
            const MeshFile inside = read_mesh(path);
            std::vector<char> beyond(inside.vertices.rows(), 0);
            for (Eigen::Index v = 0; v < inside.vertices.rows() && !excluded.empty(); ++v) {
                const ClosestPoint nearest = surface.closest(inside.vertices.row(v).transpose());
                beyond[v] = touches(skin.triangles.row(nearest.triangle_idx), left_out);
            }
            const FrameProtrusion one = frame_protrusion(skin, inside.vertices, without(inside.triangles, beyond));
            frame.intersecting.insert(frame.intersecting.end(), one.intersecting.begin(), one.intersecting.end());
            if (!one.intersecting.empty()) intersecting.insert(tissue);
            frame.protruding_vertices += one.protruding_vertices;
            frame.depth_sum_mm += one.depth_sum_mm;
            if (one.max_depth_mm > frame.max_depth_mm) deepest = tissue;
            frame.max_depth_mm = std::max(frame.max_depth_mm, one.max_depth_mm);
        }
        sum.add(frame, "frame " + name, deepest, intersecting);
        progress.advance();
    }
    return sum.row();
}

}  // namespace ndg
