// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/render.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/scene/occlusion.h"
#include "ndg/scene/ray_tracer.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace ndg {
namespace {

/// A surface made ready for shading.
struct ShadedSurface {
    const SceneSurface* surface = nullptr;
    Points normals;
    VertexColours colours;  ///< linear light; empty: `colour`
    Eigen::Vector3f colour;
    std::unique_ptr<VertexOpenness> openness;
};

struct Scene {
    std::vector<ShadedSurface> shaded;
    Eigen::Vector3d key_light, fill_light;  ///< unit, towards the light
    Eigen::Vector3f background;
    Eigen::AlignedBox3d bounds;
};

struct Fragment {
    Eigen::Vector3f colour;
    float opacity = 0;
};

/// In place: the openness refers to the normals.
void shade_surface(const SceneSurface& surface, const RayTracer& tracer, const RenderSettings& settings,
                   ShadedSurface& shaded)
{
    shaded.surface = &surface;
    shaded.normals = vertex_normals(surface.vertices, surface.triangles);
    shaded.colour = linear_from_srgb(surface.colour);
    shaded.colours = surface.vertex_colours;
    for (Eigen::Index i = 0; i < shaded.colours.size(); ++i)
        shaded.colours.data()[i] = linear_from_srgb(shaded.colours.data()[i]);
    shaded.openness = std::make_unique<VertexOpenness>(tracer, surface, shaded.normals, settings);
}

/// Nothing (opacity 0) for the back of a one-sided surface.
Fragment shade(const Scene& scene, const RayHit& hit, const Eigen::Vector3d& direction, const RenderSettings& settings)
{
    const ShadedSurface& shaded = scene.shaded[std::size_t(hit.surface_idx)];
    const SceneSurface& surface = *shaded.surface;
    const std::array<int, 3> corners = {surface.triangles(hit.triangle_idx, 0), surface.triangles(hit.triangle_idx, 1),
                                        surface.triangles(hit.triangle_idx, 2)};
    const std::array<double, 3> weights = {1.0 - double(hit.u) - double(hit.v), double(hit.u), double(hit.v)};

    const Eigen::Vector3d a = surface.vertices.row(corners[0]), b = surface.vertices.row(corners[1]),
                          c = surface.vertices.row(corners[2]);
    const Eigen::Vector3d flat_normal = (b - a).cross(c - a);
    const bool from_behind = flat_normal.dot(direction) > 0;
    Fragment fragment;
    if (from_behind && !surface.two_sided) return fragment;

    Eigen::Vector3f albedo = Eigen::Vector3f::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    float open = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        normal += weights[k] * shaded.normals.row(corners[k]).transpose();
        if (!from_behind) open += float(weights[k]) * shaded.openness->at(corners[k]);
        if (shaded.colours.rows() > 0) albedo += float(weights[k]) * shaded.colours.row(corners[k]).transpose();
    }
    if (shaded.colours.rows() == 0) albedo = shaded.colour;
    if (!settings.lit) return {albedo, surface.opacity};

    if (normal.squaredNorm() < 1e-12) normal = flat_normal;
    normal.normalize();
    if (from_behind) normal = -normal;
    const float facing = float(std::clamp(-normal.dot(direction), 0.0, 1.0));
    const float key = float(std::max(0.0, normal.dot(scene.key_light)));
    const float fill = float(std::max(0.0, normal.dot(scene.fill_light)));
    const float sky = float(0.5 + 0.5 * normal.y());
    if (from_behind) open = 0.45f;
    const float light =
        key * (0.35f + 0.65f * open) * 0.78f + fill * 0.22f * open + (0.20f + 0.22f * sky) * open * open;
    const Eigen::Vector3d half_way = (scene.key_light - direction).normalized();
    const float highlight =
        from_behind ? 0.0f : surface.gloss * open * std::pow(float(std::max(0.0, normal.dot(half_way))), 40.0f);
    fragment.colour = albedo * light + Eigen::Vector3f::Constant(highlight * 0.6f);
    const float edge = surface.edge_opacity < 0 ? surface.opacity : surface.edge_opacity;
    const float grazing = (1.0f - facing) * (1.0f - facing);
    fragment.opacity = surface.opacity + (edge - surface.opacity) * grazing;
    return fragment;
}

/// Background, darkened where the floor lies in the shade of the body.
Eigen::Vector3f shade_background(const Scene& scene, const RayTracer& tracer, const Ray& ray, float near,
                                 std::uint32_t key, const RenderSettings& settings)
{
    if (!settings.lit || !settings.ground_height || ray.direction.y() > -1e-6) return scene.background;
    const double distance = (*settings.ground_height - ray.origin.y()) / ray.direction.y();
    if (distance < double(near)) return scene.background;
    const Eigen::Vector3d point = ray.origin + distance * ray.direction;
    constexpr double reach = 0.6;
    if (scene.bounds.squaredExteriorDistance(point) > reach * reach) return scene.background;
    const float open =
        openness(tracer, point, Eigen::Vector3d::UnitY(), settings.ground_rays, reach, key, settings.clip);
    return scene.background * (1.0f - 0.75f * (1.0f - open));
}

Eigen::Vector3f trace(const Scene& scene, const RayTracer& tracer, const Ray& ray, std::uint32_t key,
                      const RenderSettings& settings)
{
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();
    float transmittance = 1.0f;
    std::vector<bool> passed(scene.shaded.size(), false);
    RaySegment segment = clip_ray(ray.origin, ray.direction, {}, settings.clip);
    const Eigen::Vector3f origin = ray.origin.cast<float>(), direction = ray.direction.cast<float>();
    while (!segment.empty() && transmittance > 2e-3f) {
        const RayHit hit = tracer.nearest(origin, direction, segment.near, segment.far);
        if (hit.surface_idx < 0) break;
        const Fragment fragment = shade(scene, hit, ray.direction, settings);
        const auto surface_idx = std::size_t(hit.surface_idx);
        const bool hidden = passed[surface_idx] && scene.shaded[surface_idx].surface->outermost_only;
        if (fragment.opacity > 0 && !hidden) {
            passed[surface_idx] = true;
            colour += transmittance * fragment.opacity * fragment.colour;
            transmittance *= 1.0f - fragment.opacity;
        }
        segment.near = hit.distance + 4e-6f * (1.0f + hit.distance);  // past this surface, float32 rounding included
    }
    if (transmittance > 2e-3f) colour += transmittance * shade_background(scene, tracer, ray, 0.0f, key, settings);
    return colour;
}

}  // namespace

Image render(const std::vector<SceneSurface>& surfaces, const Camera& camera, const RenderSettings& settings)
{
    require(settings.samples_per_axis >= 1 && settings.samples_per_axis <= 16,
            "{} x {} samples a pixel is not possible", settings.samples_per_axis, settings.samples_per_axis);
    const RayTracer tracer(surfaces);
    Scene scene;
    scene.background = linear_from_srgb(settings.background);
    scene.key_light = (-0.55 * camera.right + 0.75 * camera.up + 0.70 * camera.backward).normalized();
    scene.fill_light = (0.80 * camera.right + 0.10 * camera.up + 0.45 * camera.backward).normalized();
    scene.shaded.resize(surfaces.size());
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        shade_surface(surfaces[s], tracer, settings, scene.shaded[s]);
        for (Eigen::Index i = 0; i < surfaces[s].vertices.rows(); ++i)
            scene.bounds.extend(surfaces[s].vertices.row(i).transpose());
    }

    Image image(settings.width, settings.height);
    const double aspect = double(settings.width) / double(settings.height);
    const int samples = settings.samples_per_axis;
#pragma omp parallel for schedule(dynamic, 4)
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            for (int sy = 0; sy < samples; ++sy)
                for (int sx = 0; sx < samples; ++sx) {
                    const Ray ray = camera.ray((x + (sx + 0.5) / samples) / image.width,
                                               (y + (sy + 0.5) / samples) / image.height, aspect);
                    const std::uint32_t key =
                        hash(std::uint32_t(y * image.width + x), std::uint32_t(sy * samples + sx));
                    sum += trace(scene, tracer, ray, key, settings).cwiseMin(1.0f);
                }
            image.at(x, y) = pixel_from_linear(sum / float(samples * samples));
        }
    return image;
}

}  // namespace ndg
