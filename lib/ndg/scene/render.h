// SPDX-License-Identifier: Apache-2.0
// Pictures without a display: ray casting of surfaces with translucency, ambient occlusion and a clip plane.
#pragma once

#include "ndg/scene/camera.h"
#include "ndg/scene/image.h"
#include "ndg/scene/scene_surface.h"

#include <optional>
#include <vector>

namespace ndg {

/// What lies on the side the normal points to is cut away.
struct ClipPlane {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

struct RenderSettings {
    int width = 900, height = 1200;
    int samples_per_axis = 2;  ///< supersampling: this squared rays a pixel, averaged in linear light
    Eigen::Vector3f background = Eigen::Vector3f(0.955f, 0.96f, 0.965f);  ///< sRGB
    bool lit = true;                      ///< false: surfaces show their colour as it is, and nothing darkens anything
    int occlusion_rays = 48;              ///< rays a vertex for ambient occlusion; 0: none
    double occlusion_distance = 0.30;     ///< metres
    std::optional<double> ground_height;  ///< contact shadow on the floor at this y
    int ground_rays = 16;                 ///< for that shadow, a sample of a pixel
    std::optional<ClipPlane> clip;
};

/// Triangles seen from behind are shown darker where their surface is two-sided and skipped otherwise. Translucent
/// surfaces cast no shadow. The same input gives the same picture for any number of threads. Throws Error for malformed
/// surfaces or settings.
Image render(const std::vector<SceneSurface>& surfaces, const Camera& camera, const RenderSettings& settings);

}  // namespace ndg
