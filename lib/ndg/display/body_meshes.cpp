// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/body_meshes.h"

#include "ndg/core/error.h"
#include "ndg/io/licences.h"
#include "ndg/scene/colour_map.h"

#include <algorithm>

namespace ndg {

namespace {

/// Bones or muscles, gathered in one surface, as the parts they were gathered from.
std::vector<SceneSurface> split_into_parts(const SceneSurface& gathered, AnatomyLayer layer,
                                           const std::vector<AnatomyPart>& parts)
{
    std::vector<SceneSurface> surfaces;
    Eigen::Index vertex = 0, triangle = 0;
    for (const AnatomyPart& part : parts) {
        if (part.layer != layer) continue;
        const Eigen::Index num_vertices = part.vertex_end - part.vertex_begin;
        const Eigen::Index num_triangles = part.triangle_end - part.triangle_begin;
        SceneSurface& surface = surfaces.emplace_back(gathered);
        surface.name = part.name;
        surface.vertices = gathered.vertices.middleRows(vertex, num_vertices);
        surface.triangles = gathered.triangles.middleRows(triangle, num_triangles).array() - int(vertex);
        vertex += num_vertices;
        triangle += num_triangles;
    }
    return surfaces;
}

std::vector<SceneSurface> exported_surfaces(const Template& body_template, const BodyGeometry& geometry,
                                            const std::string& choice)
{
    std::vector<SceneSurface> surfaces;
    for (SceneSurface& gathered : anatomy_surfaces(body_template, geometry)) {
        const AnatomyLayer layer = gathered.name == "bones" ? AnatomyLayer::bone : AnatomyLayer::muscle;
        if (choice != "parts")
            surfaces.push_back(std::move(gathered));
        else
            for (SceneSurface& part : split_into_parts(gathered, layer, body_template.anatomy_parts))
                surfaces.push_back(std::move(part));
    }
    surfaces.push_back(bone_wrap_surface(body_template, geometry));
    surfaces.push_back(muscle_wrap_surface(body_template, geometry));
    surfaces.push_back(skin_surface(body_template, geometry));
    if (choice == "all" || choice == "parts") {
        // So that what lies inside shows through.
        surfaces.back().opacity = 0.35f;
        surfaces[surfaces.size() - 2].opacity = 0.5f;
        return surfaces;
    }
    const auto found = std::find_if(surfaces.begin(), surfaces.end(),
                                    [&](const SceneSurface& candidate) { return candidate.name == choice; });
    require_input(found != surfaces.end(), "--surface {}: the template has none", choice);
    return {*found};
}

/// Change of volume below each vertex of the skin, N_s; 0 for head, hands and toes.
Eigen::VectorXf skin_volume_change(const Template& body_template, const Body& body, const BodyGeometry& geometry)
{
    const Eigen::VectorXd change = volume_change(body.volume_vertices, geometry.volume_vertices, body_template.prisms,
                                                 body_template.num_wrap_vertices());
    Eigen::VectorXf values = Eigen::VectorXf::Zero(geometry.skin_vertices.rows());
    for (int w = 0; w < change.size(); ++w) values[body_template.wrap_to_skin[w]] = float(change[w]);
    return values;
}

}  // namespace

MeshSequence body_meshes(const Template& body_template, const std::string& choice, const PictureSettings& settings,
                         int num_frames, const std::function<BodyFrame(int frame_idx)>& frame)
{
    MeshSequence sequence;
    // What is the same in all frames does not depend on where vertices are.
    const BodyGeometry at_rest = rest_geometry(body_template, body_template.rest);
    for (const SceneSurface& surface : exported_surfaces(body_template, at_rest, choice))
        sequence.meshes.push_back(
            {surface.name, surface.triangles, surface.colour, surface.opacity, surface.gloss, surface.two_sided});
    if (choice == "parts")
        for (ExportedMesh& mesh : sequence.meshes)
            for (const AnatomyPart& part : body_template.anatomy_parts)
                if (part.name == mesh.name) {
                    mesh.group = part.layer == AnatomyLayer::bone ? "bones" : "muscles";
                    mesh.fma_id = part.fma_id;
                }
    sequence.num_frames = num_frames;
    sequence.frame = [frame, choice, settings, &body_template](int frame_idx) {
        const BodyFrame shown = frame(frame_idx);
        std::vector<MeshFrame> meshes;
        for (const SceneSurface& surface : exported_surfaces(body_template, shown.geometry, choice)) {
            MeshFrame& mesh = meshes.emplace_back();
            mesh.vertices = surface.vertices;
            if (!settings.volume_colours || surface.name != "skin") continue;
            mesh.colours =
                volume_change_surface(body_template, *shown.body, shown.geometry, settings.colour_range).vertex_colours;
            mesh.scalars["volume_change"] = skin_volume_change(body_template, *shown.body, shown.geometry);
        }
        return meshes;
    };
    return sequence;
}

std::string credits_of(const Provenance& provenance)
{
    std::string credits;
    for (const char c : merged_licences(provenance)) credits += c == '\n' ? "; " : std::string(1, c);
    return credits;
}

}  // namespace ndg
