// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/section.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {
namespace {

constexpr int supersampling = 3;

struct Crossing {
    double x;
    int winding;
};

/// Supersampled picture in linear light.
struct Canvas {
    int width, height;
    std::vector<Eigen::Vector3f> pixels;
    Eigen::Vector3f& at(int x, int y) { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

void fill(Canvas& canvas, const std::vector<SectionSegment>& segments, const Eigen::Vector3f& colour)
{
    std::vector<std::vector<Crossing>> rows(std::size_t(canvas.height));
    for (const SectionSegment& segment : segments) {
        const bool down = segment.begin.y() < segment.end.y();
        const Eigen::Vector2d &top = down ? segment.begin : segment.end, &bottom = down ? segment.end : segment.begin;
        // Row r is sampled at r + 1/2; half-open in y so that a corner is counted once.
        const int first = std::max(0, int(std::ceil(top.y() - 0.5)));
        const int last = std::min(canvas.height - 1, int(std::ceil(bottom.y() - 0.5)) - 1);
        for (int row = first; row <= last; ++row) {
            const double t = (row + 0.5 - top.y()) / (bottom.y() - top.y());
            rows[std::size_t(row)].push_back({top.x() + t * (bottom.x() - top.x()), down ? 1 : -1});
        }
    }
    for (int y = 0; y < canvas.height; ++y) {
        std::vector<Crossing>& crossings = rows[std::size_t(y)];
        std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
        int winding = 0;
        for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
            winding += crossings[i].winding;
            if (winding == 0) continue;
            const int first = std::max(0, int(std::ceil(crossings[i].x - 0.5)));
            const int last = std::min(canvas.width - 1, int(std::ceil(crossings[i + 1].x - 0.5)) - 1);
            for (int x = first; x <= last; ++x) canvas.at(x, y) = colour;
        }
    }
}

void outline(Canvas& canvas, const std::vector<SectionSegment>& segments, const Eigen::Vector3f& colour, double radius)
{
    for (const SectionSegment& segment : segments) {
        const Eigen::Vector2d low = segment.begin.cwiseMin(segment.end).array() - radius;
        const Eigen::Vector2d high = segment.begin.cwiseMax(segment.end).array() + radius;
        const Eigen::Vector2d along = segment.end - segment.begin;
        const double length2 = along.squaredNorm();
        for (int y = std::max(0, int(low.y())); y <= std::min(canvas.height - 1, int(high.y())); ++y)
            for (int x = std::max(0, int(low.x())); x <= std::min(canvas.width - 1, int(high.x())); ++x) {
                const Eigen::Vector2d offset = Eigen::Vector2d(x + 0.5, y + 0.5) - segment.begin;
                const double t = length2 > 0 ? std::clamp(offset.dot(along) / length2, 0.0, 1.0) : 0.0;
                if ((offset - t * along).squaredNorm() <= radius * radius) canvas.at(x, y) = colour;
            }
    }
}

}  // namespace

std::vector<SectionSegment> section_segments(const Eigen::Ref<const Points>& vertices,
                                             const Eigen::Ref<const Triangles>& triangles, const SectionPlane& plane)
{
    const Eigen::Vector3d normal = plane.right.cross(plane.up);
    Eigen::Matrix3d axes;
    axes << plane.right, plane.up, normal;
    const Points local = (vertices.rowwise() - plane.origin.transpose()) * axes;
    std::vector<SectionSegment> segments;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        SectionSegment segment;
        int crossings = 0;
        for (int k = 0; k < 3; ++k) {
            const Eigen::RowVector3d a = local.row(triangles(t, k)), b = local.row(triangles(t, (k + 1) % 3));
            // A vertex in the plane counts as above it, so every triangle is crossed twice or not at all.
            const bool a_above = a[2] >= 0, b_above = b[2] >= 0;
            if (a_above == b_above) continue;
            // From the lower to the upper end whichever way the edge runs: neighbours get the same point.
            const Eigen::RowVector3d &low = a_above ? b : a, &high = a_above ? a : b;
            const double s = low[2] / (low[2] - high[2]);
            const Eigen::Vector2d point = (low + s * (high - low)).head<2>().transpose();
            (a_above ? segment.begin : segment.end) = point;
            ++crossings;
        }
        if (crossings == 2) segments.push_back(segment);
    }
    return segments;
}

SceneSurface closed_surface(const SceneSurface& surface)
{
    const std::vector<std::vector<int>> loops = boundary_loops(surface.triangles, int(surface.vertices.rows()));
    SceneSurface closed = surface;
    Eigen::Index num_new_triangles = 0;
    for (const std::vector<int>& loop : loops) num_new_triangles += Eigen::Index(loop.size());
    Eigen::Index vertex = surface.vertices.rows(), triangle = surface.triangles.rows();
    closed.vertices.conservativeResize(vertex + Eigen::Index(loops.size()), 3);
    closed.triangles.conservativeResize(triangle + num_new_triangles, 3);
    closed.vertex_colours.resize(0, 3);
    for (const std::vector<int>& loop : loops) {
        Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
        for (const int v : loop) centre += surface.vertices.row(v) / double(loop.size());
        closed.vertices.row(vertex) = centre;
        // The surface lies to the left of the loop, so the cap runs along it the other way round.
        for (std::size_t i = 0; i < loop.size(); ++i)
            closed.triangles.row(triangle++) << loop[(i + 1) % loop.size()], loop[i], int(vertex);
        ++vertex;
    }
    return closed;
}

Image section_image(const std::vector<SceneSurface>& surfaces, const SectionPlane& plane,
                    const SectionSettings& settings)
{
    require(settings.width > 0 && settings.height > 0 && settings.pixels_per_metre > 0,
            "A section picture of {} x {} pixels at {} pixels a metre is not possible", settings.width, settings.height,
            settings.pixels_per_metre);
    Canvas canvas{settings.width * supersampling, settings.height * supersampling, {}};
    canvas.pixels.assign(std::size_t(canvas.width) * std::size_t(canvas.height), linear_from_srgb(settings.background));
    const double scale = settings.pixels_per_metre * supersampling;
    const auto to_canvas = [&](const Eigen::Vector2d& point) {
        return Eigen::Vector2d(0.5 * canvas.width + scale * (point.x() - settings.centre.x()),
                               0.5 * canvas.height - scale * (point.y() - settings.centre.y()));
    };
    for (const SceneSurface& surface : surfaces) {
        check_surface(surface);
        std::vector<SectionSegment> segments = section_segments(surface.vertices, surface.triangles, plane);
        for (SectionSegment& segment : segments) segment = {to_canvas(segment.begin), to_canvas(segment.end)};
        const Eigen::Vector3f colour = linear_from_srgb(surface.colour);
        fill(canvas, segments, colour);
        outline(canvas, segments, 0.35f * colour, 0.5 * settings.line_width * supersampling);
    }
    Image image(settings.width, settings.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            for (int sy = 0; sy < supersampling; ++sy)
                for (int sx = 0; sx < supersampling; ++sx)
                    sum += canvas.at(x * supersampling + sx, y * supersampling + sy);
            image.at(x, y) = pixel_from_linear(sum / float(supersampling * supersampling));
        }
    return image;
}

}  // namespace ndg
