// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/layer_picture.h"

#include "ndg/scene/section.h"

#include <algorithm>
#include <array>

namespace ndg {
namespace {

constexpr double bone_width = 0.012, margin = 0.03;  // m
constexpr int gap = 12;                              // pixels

/// All faces of all tetrahedra: a section fills what they fill and outlines each.
SceneSurface tetrahedra_surface(const LayerPicture& layer)
{
    SceneSurface surface;
    surface.name = "soft tissue";
    surface.colour = {0.95f, 0.80f, 0.50f};
    surface.vertices = layer.vertices;
    surface.triangles.resize(4 * layer.tetrahedra.rows(), 3);
    constexpr std::array<std::array<int, 3>, 4> faces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    Eigen::Index row = 0;
    for (Eigen::Index t = 0; t < layer.tetrahedra.rows(); ++t)
        for (const auto& face : faces)
            surface.triangles.row(row++) << layer.tetrahedra(t, face[0]), layer.tetrahedra(t, face[1]),
                layer.tetrahedra(t, face[2]);
    return surface;
}

/// A slender double pyramid a bone.
SceneSurface bones_surface(const LayerPicture& layer)
{
    SceneSurface surface;
    surface.name = "bones";
    surface.colour = {0.35f, 0.45f, 0.75f};
    const Eigen::Index count = layer.joints.rows() - 1;
    surface.vertices.resize(6 * count, 3);
    surface.triangles.resize(8 * count, 3);
    for (Eigen::Index b = 0; b < count; ++b) {
        const Eigen::Vector3d begin = layer.joints.row(layer.parents[std::size_t(b + 1)]),
                              end = layer.joints.row(b + 1);
        const Eigen::Vector3d middle = 0.5 * (begin + end), along = end - begin;
        const Eigen::Vector3d across =
            0.5 * bone_width * (along.norm() > 0 ? along.unitOrthogonal() : Eigen::Vector3d::UnitX());
        const Eigen::Vector3d other =
            along.norm() > 0 ? Eigen::Vector3d(along.normalized().cross(across)) : Eigen::Vector3d::Zero();
        const int first = int(6 * b);
        surface.vertices.row(first) = begin;
        surface.vertices.row(first + 1) = end;
        for (int k = 0; k < 4; ++k) {
            const Eigen::Vector3d corner = middle + (k % 2 == 0 ? across : other) * (k < 2 ? 1 : -1);
            surface.vertices.row(first + 2 + k) = corner;
            const int a = first + 2 + k, c = first + 2 + (k + 1) % 4;
            surface.triangles.row(8 * b + 2 * k) << first + 1, a, c;
            surface.triangles.row(8 * b + 2 * k + 1) << first, c, a;
        }
    }
    return surface;
}

Image section(const std::vector<SceneSurface>& surfaces, const SectionPlane& plane, double pixels_per_metre)
{
    const Points centred = surfaces.front().vertices.rowwise() - plane.origin.transpose();
    const Eigen::VectorXd across = centred * plane.right, up = centred * plane.up;
    SectionSettings settings;
    settings.centre = {0.5 * (across.minCoeff() + across.maxCoeff()), 0.5 * (up.minCoeff() + up.maxCoeff())};
    settings.pixels_per_metre = pixels_per_metre;
    settings.width = int(pixels_per_metre * (across.maxCoeff() - across.minCoeff() + 2 * margin));
    settings.height = int(pixels_per_metre * (up.maxCoeff() - up.minCoeff() + 2 * margin));
    settings.line_width = 0.8;
    return section_image(surfaces, plane, settings);
}

}  // namespace

Image layer_picture(const LayerPicture& layer, const std::vector<double>& heights, int height)
{
    SceneSurface skin;
    skin.name = "skin";
    skin.colour = {0.90f, 0.90f, 0.90f};
    skin.vertices = layer.skin.vertices;
    skin.triangles = layer.skin.triangles;
    const std::vector<SceneSurface> surfaces = {skin, tetrahedra_surface(layer), bones_surface(layer)};
    const Eigen::Vector3d middle =
        0.5 * (skin.vertices.colwise().minCoeff() + skin.vertices.colwise().maxCoeff()).transpose();
    const Eigen::Vector3d root = layer.joints.row(0);
    const double tall = skin.vertices.col(1).maxCoeff() - skin.vertices.col(1).minCoeff() + 2 * margin;
    const double scale = height / tall;

    SectionPlane frontal{{0, 0, root.z()}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
    SectionPlane sagittal{{root.x(), 0, middle.z()}, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY()};
    std::vector<Image> images = {section(surfaces, frontal, scale), section(surfaces, sagittal, scale)};
    for (const double level : heights) {
        const SectionPlane plane{{0, level, 0}, Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
        images.push_back(section(surfaces, plane, 2 * scale));
    }
    // Upright sections side by side, the horizontal ones in a column beside them.
    int width = gap, column_width = 0, column_height = gap;
    for (int i = 0; i < 2; ++i) width += images[std::size_t(i)].width + gap;
    for (std::size_t i = 2; i < images.size(); ++i) {
        column_width = std::max(column_width, images[i].width + gap);
        column_height += images[i].height + gap;
    }
    Image sheet(width + column_width, std::max(images[0].height + 2 * gap, column_height));
    int x = gap, y = gap;
    for (std::size_t i = 0; i < images.size(); ++i) {
        paste(sheet, images[i], x, y);
        if (i < 2)
            x += images[i].width + gap;
        else
            y += images[i].height + gap;
    }
    return tile_images({sheet}, 1, {layer.title, {}, {}, ""});
}

}  // namespace ndg
