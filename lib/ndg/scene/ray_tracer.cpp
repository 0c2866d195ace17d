// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/ray_tracer.h"

#include "ndg/core/error.h"

#include <embree3/rtcore.h>

#include <cmath>

namespace ndg {

struct RayTracer::State {
    RTCDevice device = nullptr;
    RTCScene all = nullptr;     ///< every surface; geometry id = surface index
    RTCScene opaque = nullptr;  ///< the surfaces that cast shadows

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State()
    {
        if (all) rtcReleaseScene(all);
        if (opaque) rtcReleaseScene(opaque);
        if (device) rtcReleaseDevice(device);
    }
};

namespace {

void attach_surface(RTCDevice device, const SceneSurface& surface, unsigned surface_idx, RTCScene all, RTCScene opaque)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices =
        static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                    3 * sizeof(float), std::size_t(surface.vertices.rows())));
    auto* indices =
        static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                       3 * sizeof(unsigned), std::size_t(surface.triangles.rows())));
    const bool allocated = vertices != nullptr && indices != nullptr;
    if (allocated) {
        for (Eigen::Index i = 0; i < surface.vertices.size(); ++i) vertices[i] = float(surface.vertices.data()[i]);
        for (Eigen::Index i = 0; i < surface.triangles.size(); ++i) indices[i] = unsigned(surface.triangles.data()[i]);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(all, geometry, surface_idx);
        if (surface.opacity >= 1.0f) rtcAttachGeometryByID(opaque, geometry, surface_idx);
    }
    rtcReleaseGeometry(geometry);
    require(allocated, "Embree could not allocate surface \"{}\" of {} triangles", surface.name,
            surface.triangles.rows());
}

RTCRay make_ray(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far)
{
    RTCRay ray{};
    ray.org_x = origin.x();
    ray.org_y = origin.y();
    ray.org_z = origin.z();
    ray.dir_x = direction.x();
    ray.dir_y = direction.y();
    ray.dir_z = direction.z();
    ray.tnear = near;
    ray.tfar = far;
    ray.mask = ~0u;
    return ray;
}

}  // namespace

RayTracer::RayTracer(const std::vector<SceneSurface>& surfaces) : state_(std::make_unique<State>())
{
    // One build thread: the order of a parallel build could decide which of two touching triangles a ray reports.
    state_->device = rtcNewDevice("threads=1");
    require(state_->device != nullptr, "Embree could not be started (error {})", int(rtcGetDeviceError(nullptr)));
    state_->all = rtcNewScene(state_->device);
    state_->opaque = rtcNewScene(state_->device);
    rtcSetSceneFlags(state_->all, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneFlags(state_->opaque, RTC_SCENE_FLAG_ROBUST);
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        check_surface(surfaces[i]);
        attach_surface(state_->device, surfaces[i], unsigned(i), state_->all, state_->opaque);
    }
    rtcCommitScene(state_->all);
    rtcCommitScene(state_->opaque);
    const RTCError error = rtcGetDeviceError(state_->device);
    require(error == RTC_ERROR_NONE, "Embree could not build its scene (error {})", int(error));
}

RayTracer::~RayTracer() = default;

RayHit RayTracer::nearest(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) const
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray = make_ray(origin, direction, near, far);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(state_->all, &context, &query);
    RayHit hit;
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
    hit.surface_idx = int(query.hit.geomID);
    hit.triangle_idx = int(query.hit.primID);
    hit.distance = query.ray.tfar;
    hit.u = query.hit.u;
    hit.v = query.hit.v;
    return hit;
}

bool RayTracer::occluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) const
{
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray = make_ray(origin, direction, near, far);
    rtcOccluded1(state_->opaque, &context, &ray);
    return ray.tfar < 0.0f;  // Embree's mark for a blocked ray: minus infinity
}

}  // namespace ndg
