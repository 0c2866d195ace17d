// SPDX-License-Identifier: Apache-2.0
#include "ndg/people/exaggeration.h"

#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/placement/skeleton_placer.h"

#include <algorithm>

namespace ndg {

SkinSet exaggerated_person(const Template& body_template, const SkinSet& skins, int body_idx, double factor)
{
    require_input(body_idx >= 0 && body_idx < int(skins.bodies.size()), "there is no person {} among {}", body_idx,
                  skins.bodies.size());
    SkinSet result = skins;
    result.parameters = skins.parameters.row(body_idx).eval();
    Skin skin = skins.bodies[body_idx];
    const Skin& usual = body_template.rest;
    skin.name = fmt::format("{} exaggerated {:.2f} times", skin.name, factor);
    skin.skin_vertices = usual.skin_vertices + factor * (skin.skin_vertices - usual.skin_vertices);
    skin.joint_positions = usual.joint_positions + factor * (skin.joint_positions - usual.joint_positions);
    const double floor = skin.skin_vertices.col(1).minCoeff();
    skin.skin_vertices.col(1).array() -= floor;
    skin.joint_positions.col(1).array() -= floor;

    const auto parameter = [&](const std::string& name) -> double* {
        const auto found = std::find(result.parameter_names.begin(), result.parameter_names.end(), name);
        return found == result.parameter_names.end() ? nullptr
                                                     : &result.parameters(0, found - result.parameter_names.begin());
    };
    const double* const sex = parameter("sex");
    if (SkeletonPlacer::has_trunk_bones(body_template)) {
        const SkeletonPlacer placer(body_template);
        skin.joint_positions = placer.joints(skin, placer.trunk_map(skin, sex ? *sex : 0.5));
    }
    const double height = skin.skin_vertices.col(1).maxCoeff();
    const double mass = body_density * enclosed_volume(skin.skin_vertices, body_template.skin_triangles);
    const std::pair<const char*, double> values[] = {
        {"stature_m", height}, {"mass_kg", mass}, {"bmi", mass / (height * height)}};
    for (const auto& [name, value] : values)
        if (double* const stored = parameter(name)) *stored = value;
    result.bodies = {std::move(skin)};
    return result;
}

}  // namespace ndg
