// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/occlusion.h"

#include <algorithm>
#include <cmath>

namespace ndg {

RaySegment clip_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, RaySegment segment,
                    const std::optional<ClipPlane>& clip)
{
    if (!clip) return segment;
    const double height = (origin - clip->point).dot(clip->normal);  // > 0: cut away
    const double slope = direction.dot(clip->normal);
    if (std::abs(slope) < 1e-12) {
        if (height > 0) segment.far = segment.near;
        return segment;
    }
    const float crossing = float(-height / slope);
    if (slope > 0)
        segment.far = std::min(segment.far, crossing);
    else
        segment.near = std::max(segment.near, crossing);
    return segment;
}

std::uint32_t hash(std::uint32_t a, std::uint32_t b)
{
    std::uint64_t x = (std::uint64_t(a) << 32) | b;  // splitmix64
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return std::uint32_t((x ^ (x >> 31)) >> 32);
}

float openness(const RayTracer& tracer, const Eigen::Vector3d& point, const Eigen::Vector3d& normal, int rays,
               double distance, std::uint32_t key, const std::optional<ClipPlane>& clip)
{
    const Eigen::Vector3d tangent = normal.unitOrthogonal();
    const Eigen::Vector3d bitangent = normal.cross(tangent);
    const Eigen::Vector3d origin = point + 1e-3 * normal;
    const double turn = double(key) / 4294967296.0;
    constexpr double golden_ratio = 0.6180339887498949;
    int open = 0;
    for (int i = 0; i < rays; ++i) {
        // Uniform on the disc, projected up to the hemisphere: density proportional to the cosine.
        const double radius = std::sqrt((i + 0.5) / rays);
        const double angle = 2.0 * M_PI * (i * golden_ratio + turn);
        const Eigen::Vector3d direction = radius * std::cos(angle) * tangent + radius * std::sin(angle) * bitangent +
                                          std::sqrt(std::max(0.0, 1.0 - radius * radius)) * normal;
        const RaySegment segment = clip_ray(origin, direction, {0.0f, float(distance)}, clip);
        if (segment.empty() ||
            !tracer.occluded(origin.cast<float>(), direction.cast<float>(), segment.near, segment.far))
            ++open;
    }
    return float(open) / float(rays);
}

std::vector<float> vertex_openness(const RayTracer& tracer, const SceneSurface& surface,
                                   const Eigen::Ref<const Points>& normals, const RenderSettings& settings)
{
    const int num_vertices = int(surface.vertices.rows());
    std::vector<float> open(std::size_t(num_vertices), 1.0f);
    if (!settings.lit || settings.occlusion_rays <= 0 || surface.opacity < 1.0f) return open;
#pragma omp parallel for schedule(dynamic, 256)
    for (int i = 0; i < num_vertices; ++i) {
        const Eigen::Vector3d normal = normals.row(i).transpose();
        if (normal.squaredNorm() < 0.5) continue;  // no triangle uses this vertex
        open[std::size_t(i)] = openness(tracer, surface.vertices.row(i).transpose(), normal, settings.occlusion_rays,
                                        settings.occlusion_distance, hash(std::uint32_t(i), 0x0cc1u), settings.clip);
    }
    std::vector<float> sums(open.size(), 0.0f), counts(open.size(), 0.0f);
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) {
            const auto vertex = std::size_t(surface.triangles(t, k));
            sums[vertex] += open[std::size_t(surface.triangles(t, (k + 1) % 3))] +
                            open[std::size_t(surface.triangles(t, (k + 2) % 3))];
            counts[vertex] += 2.0f;
        }
    for (std::size_t i = 0; i < open.size(); ++i)
        if (counts[i] > 0) open[i] = 0.5f * open[i] + 0.5f * sums[i] / counts[i];
    return open;
}

}  // namespace ndg
