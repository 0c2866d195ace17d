// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/fit_picture.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/scene/camera.h"
#include "ndg/scene/colour_map.h"
#include "ndg/scene/render.h"

#include <array>
#include <cmath>

namespace ndg {
namespace {

constexpr double disc_radius = 1.6;  ///< in spacings
constexpr int disc_corners = 3;
const Eigen::Vector3f scan_colour(0.62f, 0.66f, 0.72f), skin_colour(0.85f, 0.72f, 0.63f),
    unseen_colour(0.6f, 0.6f, 0.6f);

SceneSurface disc_surface(const FitPicture& fit)
{
    SceneSurface surface;
    surface.name = "scan";
    surface.colour = scan_colour;
    surface.gloss = 0.0f;
    const Eigen::Index count = fit.points.rows();
    surface.vertices.resize(disc_corners * count, 3);
    surface.triangles.resize(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const Eigen::Vector3d normal = fit.normals.row(i).transpose();
        const Eigen::Vector3d across = normal.unitOrthogonal(), up = normal.cross(across);
        for (int k = 0; k < disc_corners; ++k) {
            const double angle = 2.0 * EIGEN_PI * k / disc_corners;
            surface.vertices.row(disc_corners * i + k) =
                fit.points.row(i) +
                disc_radius * fit.spacing * (std::cos(angle) * across + std::sin(angle) * up).transpose();
        }
        surface.triangles.row(i) << int(disc_corners * i), int(disc_corners * i + 1), int(disc_corners * i + 2);
    }
    return surface;
}

/// Mean signed distance of the points nearest to the triangles around each vertex.
VertexColours distance_colours(const FitPicture& fit, double range)
{
    const TriangleTree tree(fit.surface, fit.triangles);
    const Points normals = triangle_normals(fit.surface, fit.triangles);
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(fit.surface.rows()), weights = sums;
    for (Eigen::Index i = 0; i < fit.points.rows(); ++i) {
        const Eigen::Vector3d point = fit.points.row(i).transpose();
        const ClosestPoint closest = tree.closest(point);
        if (closest.distance > 3.0 * range) continue;
        const double side = normals.row(closest.triangle_idx).dot((point - closest.point).transpose());
        for (int k = 0; k < 3; ++k) {
            const int v = fit.triangles(closest.triangle_idx, k);
            sums[v] += closest.barycentric[k] * std::copysign(closest.distance, side);
            weights[v] += closest.barycentric[k];
        }
    }
    VertexColours colours(fit.surface.rows(), 3);
    for (Eigen::Index v = 0; v < sums.size(); ++v) {
        colours.row(v) = (weights[v] > 0 ? diverging_colour(sums[v] / weights[v] / range) : unseen_colour).transpose();
    }
    return colours;
}

}  // namespace

Image fit_picture(const FitPicture& fit, double range, int height)
{
    SceneSurface skin;
    skin.name = "fit";
    skin.vertices = fit.surface;
    skin.triangles = fit.triangles;
    skin.colour = skin_colour;
    SceneSurface distances = skin;
    distances.name = "distance";
    distances.vertex_colours = distance_colours(fit, range);
    distances.gloss = 0.0f;
    RenderSettings settings;
    settings.height = height;
    settings.width = height * 4 / 5;
    std::vector<Image> images;
    for (const SceneSurface& surface : {disc_surface(fit), skin, distances}) {
        settings.occlusion_rays = surface.name == "fit" ? 32 : 0;
        for (const View view : {View::front, View::back, View::left}) {
            const Camera camera =
                frame_points(fit.surface, view_direction(view, fit.heading), double(settings.width) / settings.height);
            images.push_back(render({surface}, camera, settings));
        }
    }
    SheetLabels labels;
    labels.title = fit.title;
    labels.columns = {"front", "back", "left"};
    labels.rows = {"scan", "fit", "distance"};
    labels.footer = fit.footer;
    return tile_images(images, 3, labels);
}

}  // namespace ndg
