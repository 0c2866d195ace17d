// SPDX-License-Identifier: Apache-2.0
// A body at rest or posed, as surfaces to be shown.
#pragma once

#include "ndg/body/template.h"
#include "ndg/deform/posed_body.h"
#include "ndg/scene/scene_surface.h"

#include <vector>

namespace ndg {

/// Where everything of one body is, in the template's numbering.
struct BodyGeometry {
    Points skin_vertices;     ///< N_s x 3, head, hands and toes included
    Points volume_vertices;   ///< N_v x 3
    Points anatomy_vertices;  ///< N_a x 3; no rows for a template without anatomy
    double heading = 0;       ///< angle in radians about +y by which the pelvis is turned away from +z
};

BodyGeometry rest_geometry(const Template& body_template, const Body& body);
/// `deformed_volume`: N_v x 3 from FEM or a prediction. Head, hands, toes and the inside of the bone wrap follow the
/// pose by linear blend skinning. Throws Error for a wrong number of rows.
BodyGeometry posed_geometry(const PosedBody& posed, const Eigen::Ref<const Points>& deformed_volume);
/// The same with the anatomy (N_a x 3) given, for what does not carry it by the volume.
BodyGeometry posed_geometry(const PosedBody& posed, const Eigen::Ref<const Points>& deformed_volume,
                            const Eigen::Ref<const Points>& anatomy);
/// The same with all volume vertices moved by linear blend skinning.
BodyGeometry skinned_geometry(const PosedBody& posed);

SceneSurface skin_surface(const Template& body_template, const BodyGeometry& geometry);
/// The skin as a faint translucent shell around other surfaces.
SceneSurface skin_shell(const Template& body_template, const BodyGeometry& geometry);
/// The outer surface of the volume alone: the skin without head, hands and toes, open at the cuts.
SceneSurface skin_wrap_surface(const Template& body_template, const BodyGeometry& geometry);
SceneSurface muscle_wrap_surface(const Template& body_template, const BodyGeometry& geometry);
SceneSurface bone_wrap_surface(const Template& body_template, const BodyGeometry& geometry);
/// "bones" and "muscles", each where the template has such anatomy.
std::vector<SceneSurface> anatomy_surfaces(const Template& body_template, const BodyGeometry& geometry);

/// Skin coloured by the volume change of the tissue below it: blue is lost, red is gained, full colour at `range`.
/// Head, hands and toes, which carry no volume, are plain grey.
SceneSurface volume_change_surface(const Template& body_template, const Body& body, const BodyGeometry& geometry,
                                   double range);

}  // namespace ndg
