// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/ray_tracer.h"
#include "ndg/scene/render.h"

#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

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

/// Openness of the vertices of an opaque surface, smoothed once over neighbours; 1 everywhere on others. Rays are only
/// spent on vertices that are asked for and their neighbours: of a body with its anatomy most are never seen. May be
/// asked from several threads at once. Keeps references to what it is made of. `normals`: N x 3.
class VertexOpenness {
public:
    VertexOpenness(const RayTracer& tracer, const SceneSurface& surface, const Points& normals,
                   const RenderSettings& settings);
    float at(int vertex) const;

private:
    float unsmoothed(int vertex) const;

    const RayTracer& tracer_;
    const SceneSurface& surface_;
    const Points& normals_;
    const RenderSettings& settings_;
    std::vector<int> triangles_begin_, triangles_of_;  ///< triangles about each vertex, in their order; empty: all open
    /// Negative: not known yet. Two threads may both find out; they find the same.
    mutable std::vector<std::atomic<float>> unsmoothed_, smoothed_;
};

}  // namespace ndg
