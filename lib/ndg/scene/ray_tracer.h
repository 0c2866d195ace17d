// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/scene_surface.h"

#include <memory>
#include <vector>

namespace ndg {

struct RayHit {
    int surface_idx = -1;  ///< -1: nothing was hit
    int triangle_idx = -1;
    float distance = 0;  ///< along the ray, in units of its direction's length
    float u = 0, v = 0;  ///< barycentric weights of the triangle's second and third vertex
};

/// Ray queries against triangle surfaces (Embree). Queries may run in several threads at once.
class RayTracer {
public:
    /// Throws Error when a surface is malformed or Embree fails.
    explicit RayTracer(const std::vector<SceneSurface>& surfaces);
    ~RayTracer();
    RayTracer(const RayTracer&) = delete;
    RayTracer& operator=(const RayTracer&) = delete;

    RayHit nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) const;
    /// Whether an opaque surface lies on the segment.
    bool occluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
