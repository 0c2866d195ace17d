// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/ray_tracer.h"
#include "ndg/scene/render.h"

#include <cstdint>
#include <limits>

namespace ndg {

/// Part of a ray that lies on the visible side of a clip plane.
struct RaySegment {
    float near = 0, far = std::numeric_limits<float>::infinity();
    bool empty() const { return !(near < far); }
};
RaySegment clip_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, RaySegment segment,
                    const std::optional<ClipPlane>& clip);

/// Well mixed 32 bits of two numbers (a hash, so that noise depends on the place and on nothing else).
std::uint32_t hash(std::uint32_t a, std::uint32_t b);

/// Cosine-weighted share of the hemisphere above `normal` that opaque surfaces leave open, in [0, 1]. `rays` directions
/// on a Fibonacci spiral turned by `key`.
float openness(const RayTracer& tracer, const Eigen::Vector3d& point, const Eigen::Vector3d& normal, int rays,
               double distance, std::uint32_t key, const std::optional<ClipPlane>& clip);

/// Openness of every vertex of an opaque surface, smoothed once over neighbours. `normals`: N x 3.
std::vector<float> vertex_openness(const RayTracer& tracer, const SceneSurface& surface,
                                   const Eigen::Ref<const Points>& normals, const RenderSettings& settings);

}  // namespace ndg
