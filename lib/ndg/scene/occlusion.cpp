// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/occlusion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

VertexOpenness::VertexOpenness(const RayTracer& tracer, const SceneSurface& surface, const Points& normals,
                               const RenderSettings& settings)
    : tracer_(tracer), surface_(surface), normals_(normals), settings_(settings)
{
    if (!settings.lit || settings.occlusion_rays <= 0 || surface.opacity < 1.0f) return;
    const auto num_vertices = std::size_t(surface.vertices.rows());
    unsmoothed_ = std::vector<std::atomic<float>>(num_vertices);
    smoothed_ = std::vector<std::atomic<float>>(num_vertices);
    for (std::size_t i = 0; i < num_vertices; ++i) {
        unsmoothed_[i].store(-1.0f, std::memory_order_relaxed);
        smoothed_[i].store(-1.0f, std::memory_order_relaxed);
    }
    triangles_begin_.assign(num_vertices + 1, 0);
    for (Eigen::Index i = 0; i < surface.triangles.size(); ++i) ++triangles_begin_[surface.triangles.data()[i] + 1];
    std::partial_sum(triangles_begin_.begin(), triangles_begin_.end(), triangles_begin_.begin());
    triangles_of_.resize(std::size_t(surface.triangles.size()));
    std::vector<int> next(triangles_begin_.begin(), triangles_begin_.end() - 1);
    for (int t = 0; t < int(surface.triangles.rows()); ++t)
        for (int k = 0; k < 3; ++k) triangles_of_[next[surface.triangles(t, k)]++] = t;
}

float VertexOpenness::unsmoothed(int vertex) const
{
    float open = unsmoothed_[vertex].load(std::memory_order_relaxed);
    if (open >= 0.0f) return open;
    const Eigen::Vector3d normal = normals_.row(vertex).transpose();
    open = 1.0f;
    if (normal.squaredNorm() >= 0.5)  // otherwise no triangle uses this vertex
        open = openness(tracer_, surface_.vertices.row(vertex).transpose(), normal, settings_.occlusion_rays,
                        settings_.occlusion_distance, hash(std::uint32_t(vertex), 0x0cc1u), settings_.clip);
    unsmoothed_[vertex].store(open, std::memory_order_relaxed);
    return open;
}

float VertexOpenness::at(int vertex) const
{
    if (triangles_begin_.empty()) return 1.0f;
    float open = smoothed_[vertex].load(std::memory_order_relaxed);
    if (open >= 0.0f) return open;
    float sum = 0.0f, count = 0.0f;
    for (int i = triangles_begin_[vertex]; i < triangles_begin_[vertex + 1]; ++i) {
        const auto corners = surface_.triangles.row(triangles_of_[i]);
        for (int k = 0; k < 3; ++k) {
            if (corners[k] != vertex) continue;
            sum += unsmoothed(corners[(k + 1) % 3]) + unsmoothed(corners[(k + 2) % 3]);
            count += 2.0f;
            break;
        }
    }
    open = unsmoothed(vertex);
    if (count > 0) open = 0.5f * open + 0.5f * sum / count;
    smoothed_[vertex].store(open, std::memory_order_relaxed);
    return open;
}

}  // namespace ndg
