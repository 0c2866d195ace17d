// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/body_surfaces.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/scene/colour_map.h"

#include <cmath>

namespace ndg {
namespace {

const Eigen::Vector3f skin_colour(0.85f, 0.73f, 0.65f), muscle_colour(0.70f, 0.22f, 0.20f),
    bone_wrap_colour(0.86f, 0.76f, 0.58f), bone_colour(0.93f, 0.89f, 0.78f);

SceneSurface wrap_surface(const std::string& name, const Template& body_template, const BodyGeometry& geometry,
                          int wrap, const Eigen::Vector3f& colour)
{
    const int num_wrap = body_template.num_wrap_vertices();
    require(geometry.volume_vertices.rows() == 3 * num_wrap, "A body has {} volume vertices, its template {}",
            geometry.volume_vertices.rows(), 3 * num_wrap);
    SceneSurface surface;
    surface.name = name;
    surface.vertices = geometry.volume_vertices.middleRows(wrap * num_wrap, num_wrap);
    surface.triangles = body_template.wrap_triangles;
    surface.colour = colour;
    return surface;
}

/// The anatomy parts of one kind as one surface with its own vertex numbering.
SceneSurface gather_anatomy(const std::string& name, AnatomyLayer kind, const Template& body_template,
                            const BodyGeometry& geometry)
{
    SceneSurface surface;
    surface.name = name;
    Eigen::Index num_vertices = 0, num_triangles = 0;
    for (const AnatomyPart& part : body_template.anatomy_parts)
        if (part.layer == kind) {
            num_vertices += part.vertex_end - part.vertex_begin;
            num_triangles += part.triangle_end - part.triangle_begin;
        }
    surface.vertices.resize(num_vertices, 3);
    surface.triangles.resize(num_triangles, 3);
    Eigen::Index vertex = 0, triangle = 0;
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != kind) continue;
        const Eigen::Index part_vertices = part.vertex_end - part.vertex_begin;
        const Eigen::Index part_triangles = part.triangle_end - part.triangle_begin;
        surface.vertices.middleRows(vertex, part_vertices) =
            geometry.anatomy_vertices.middleRows(part.vertex_begin, part_vertices);
        surface.triangles.middleRows(triangle, part_triangles) =
            body_template.anatomy_triangles.middleRows(part.triangle_begin, part_triangles).array() +
            int(vertex - part.vertex_begin);
        vertex += part_vertices;
        triangle += part_triangles;
    }
    return surface;
}

}  // namespace

BodyGeometry rest_geometry(const Template& body_template, const Body& body)
{
    return {body.skin_vertices, body.volume_vertices, anatomy_at_rest(body_template, body), 0.0};
}

BodyGeometry posed_geometry(const PosedBody& posed, const Eigen::Ref<const Points>& deformed_volume)
{
    const Points at_rest = anatomy_at_rest(posed.body_template(), posed.body());
    return posed_geometry(posed, deformed_volume, posed.anatomy(at_rest, deformed_volume));
}

BodyGeometry posed_geometry(const PosedBody& posed, const Eigen::Ref<const Points>& deformed_volume,
                            const Eigen::Ref<const Points>& anatomy)
{
    BodyGeometry geometry;
    geometry.skin_vertices = posed.display_skin(deformed_volume);
    geometry.volume_vertices = deformed_volume;
    geometry.anatomy_vertices = anatomy;
    const Eigen::Vector3d forward = posed.world_from_rest()[0].linear().col(2);
    // A body lying down has no heading; it is then shown from +z.
    if (std::hypot(forward.x(), forward.z()) > 0.3) geometry.heading = std::atan2(forward.x(), forward.z());
    return geometry;
}

BodyGeometry skinned_geometry(const PosedBody& posed)
{
    return posed_geometry(posed, posed.skinned_volume());
}

SceneSurface skin_surface(const Template& body_template, const BodyGeometry& geometry)
{
    SceneSurface surface;
    surface.name = "skin";
    surface.vertices = geometry.skin_vertices;
    surface.triangles = body_template.skin_triangles;
    surface.colour = skin_colour;
    return surface;
}

SceneSurface skin_shell(const Template& body_template, const BodyGeometry& geometry)
{
    SceneSurface surface = skin_surface(body_template, geometry);
    surface.colour = {0.62f, 0.70f, 0.78f};
    surface.opacity = 0.13f;
    surface.edge_opacity = 0.62f;
    surface.gloss = 0.35f;
    surface.two_sided = false;
    surface.outermost_only = true;
    return surface;
}

SceneSurface skin_wrap_surface(const Template& body_template, const BodyGeometry& geometry)
{
    return wrap_surface("skin_wrap", body_template, geometry, 2, skin_colour);
}

SceneSurface muscle_wrap_surface(const Template& body_template, const BodyGeometry& geometry)
{
    SceneSurface surface = wrap_surface("muscle_wrap", body_template, geometry, 1, muscle_colour);
    surface.gloss = 0.25f;
    return surface;
}

SceneSurface bone_wrap_surface(const Template& body_template, const BodyGeometry& geometry)
{
    return wrap_surface("bone_wrap", body_template, geometry, 0, bone_wrap_colour);
}

std::vector<SceneSurface> anatomy_surfaces(const Template& body_template, const BodyGeometry& geometry)
{
    SceneSurface bones = gather_anatomy("bones", AnatomyLayer::bone, body_template, geometry);
    SceneSurface muscles = gather_anatomy("muscles", AnatomyLayer::muscle, body_template, geometry);
    bones.colour = bone_colour;
    muscles.colour = muscle_colour;
    muscles.gloss = 0.25f;
    std::vector<SceneSurface> surfaces;
    if (bones.triangles.rows() > 0) surfaces.push_back(std::move(bones));
    if (muscles.triangles.rows() > 0) surfaces.push_back(std::move(muscles));
    return surfaces;
}

SceneSurface volume_change_surface(const Template& body_template, const Body& body, const BodyGeometry& geometry,
                                   double range)
{
    require(range > 0, "The range of a volume change must be positive, not {}", range);
    SceneSurface surface = skin_surface(body_template, geometry);
    const Eigen::VectorXd change = volume_change(body.volume_vertices, geometry.volume_vertices, body_template.prisms,
                                                 body_template.num_wrap_vertices());
    surface.vertex_colours = Eigen::RowVector3f(0.80f, 0.80f, 0.80f).replicate(surface.vertices.rows(), 1);
    for (int w = 0; w < body_template.num_wrap_vertices(); ++w)
        surface.vertex_colours.row(body_template.wrap_to_skin[std::size_t(w)]) =
            diverging_colour(change[w] / range).transpose();
    surface.gloss = 0.05f;
    return surface;
}

}  // namespace ndg
