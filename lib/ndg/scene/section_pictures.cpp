// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/scene/pictures.h"
#include "ndg/scene/section.h"
#include "ndg/scene/text.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

const Pixel paper_colour = {244, 245, 246};

struct Level {
    std::string name;
    double height;  ///< metres
};

std::vector<Level> section_levels(const Skeleton& skeleton, const Body& body)
{
    const auto joint_height = [&](const std::string& name) { return body.joint_positions(skeleton.joint(name), 1); };
    const auto between = [&](const std::string& a, const std::string& b) {
        return 0.5 * (joint_height(a) + joint_height(b));
    };
    std::vector<Level> levels = {{"chest", joint_height("spine_4")},
                                 {"upper arm", between("left_upper_arm", "left_forearm")},
                                 {"abdomen", joint_height("spine_2")},
                                 {"hip", joint_height("left_thigh")},
                                 {"thigh", between("left_thigh", "left_shin")}};
    std::stable_sort(levels.begin(), levels.end(), [](const Level& a, const Level& b) { return a.height > b.height; });
    return levels;
}

/// Outermost first, closed, in the colours of the legend.
std::vector<Layer> section_layers(const Template& body_template, const BodyGeometry& geometry)
{
    Layer skin = skin_layer(body_template, geometry);
    skin.colour = {0.95f, 0.80f, 0.50f};
    Layer muscle = closed_layer(muscle_wrap_layer(body_template, geometry));
    muscle.colour = {0.80f, 0.36f, 0.32f};
    Layer core = closed_layer(bone_wrap_layer(body_template, geometry));
    core.colour = {0.72f, 0.74f, 0.78f};
    std::vector<Layer> layers = {skin, muscle, core};
    for (Layer& layer : anatomy_layers(body_template, geometry)) {
        layer.colour =
            layer.name == "bones" ? Eigen::Vector3f(0.98f, 0.96f, 0.88f) : Eigen::Vector3f(0.60f, 0.16f, 0.16f);
        // Bones over muscles, whatever order the template stores them in.
        if (layer.name == "bones")
            layers.push_back(layer);
        else
            layers.insert(layers.begin() + 3, layer);
    }
    return layers;
}

struct Extent {
    Eigen::Vector2d centre, size;
};

/// Bounding box of the points in plane coordinates, grown by a margin.
Extent plane_extent(const Points& points, const SectionPlane& plane)
{
    const Points centred = points.rowwise() - plane.origin.transpose();
    const Eigen::VectorXd across = centred * plane.right, upward = centred * plane.up;
    const Eigen::Vector2d low(across.minCoeff(), upward.minCoeff()), high(across.maxCoeff(), upward.maxCoeff());
    return {0.5 * (low + high), (high - low) * 1.04};
}

Image draw(const std::vector<Layer>& layers, const SectionPlane& plane, const Extent& extent, double pixels_per_metre,
           const std::string& label)
{
    SectionSettings settings;
    settings.centre = extent.centre;
    settings.pixels_per_metre = pixels_per_metre;
    settings.width = std::max(1, int(std::ceil(extent.size.x() * pixels_per_metre)));
    settings.height = std::max(1, int(std::ceil(extent.size.y() * pixels_per_metre)));
    Image image = section_image(layers, plane, settings);
    draw_text(image, label, 6, 6, 2, {45, 52, 60});
    return image;
}

Image legend(const std::vector<Layer>& layers, int width)
{
    Image image(width, 30, paper_colour);
    const std::vector<std::pair<std::string, std::string>> names = {{"skin", "fat layer"},
                                                                    {"muscle_wrap", "muscle layer"},
                                                                    {"bone_wrap", "inside of bone wrap"},
                                                                    {"bones", "bones"},
                                                                    {"muscles", "muscles"}};
    int x = 8;
    for (const Layer& layer : layers) {
        std::string text = layer.name;
        for (const auto& [name, description] : names)
            if (layer.name == name) text = description;
        const Image swatch(14, 14, pixel_from_linear(linear_from_srgb(layer.colour)));
        paste(image, swatch, x, 8);
        draw_text(image, text, x + 20, 8, 2, {45, 52, 60});
        x += 20 + text_width(text, 2) + 22;
    }
    return image;
}

}  // namespace

Image sections_picture(const Template& body_template, const Body& body, const PictureSettings& settings)
{
    const BodyGeometry geometry = rest_geometry(body_template, body);
    const std::vector<Layer> layers = section_layers(body_template, geometry);
    const Skeleton& skeleton = body_template.skeleton;

    // Frontal section: the body faces the reader, its left side on the right hand as in the front view.
    SectionPlane frontal;
    frontal.origin = body.joint_positions.row(skeleton.joint("left_upper_arm")).transpose();
    frontal.origin.x() = 0;
    const Extent frontal_extent = plane_extent(body.skin_vertices, frontal);
    const double frontal_scale = settings.height / frontal_extent.size.y();
    const Image left = draw(layers, frontal, frontal_extent, frontal_scale, "frontal");

    // Horizontal sections, seen from above with the front of the body at the bottom; one scale for all.
    const std::vector<Level> levels = section_levels(skeleton, body);
    SectionPlane horizontal;
    horizontal.right = Eigen::Vector3d::UnitX();
    horizontal.up = -Eigen::Vector3d::UnitZ();
    std::vector<Extent> extents;
    double total_depth = 0, largest_width = 0;
    for (const Level& level : levels) {
        horizontal.origin = {0, level.height, 0};
        std::vector<Eigen::RowVector3d> near;
        for (const SectionSegment& segment : section_segments(layers[0].vertices, layers[0].triangles, horizontal))
            near.emplace_back(segment.begin.x(), 0, -segment.begin.y());
        require(!near.empty(), "The {} section at {:.3f} m misses the skin", level.name, level.height);
        Points outline(Eigen::Index(near.size()), 3);
        for (std::size_t i = 0; i < near.size(); ++i) outline.row(Eigen::Index(i)) = near[i];
        extents.push_back(plane_extent(outline, horizontal));
        total_depth += extents.back().size.y();
        largest_width = std::max(largest_width, extents.back().size.x());
    }
    constexpr int gap = 10;
    const double scale = std::min((settings.height - gap * double(levels.size())) / std::max(1e-6, total_depth),
                                  1.2 * settings.height / std::max(1e-6, largest_width));
    std::vector<Image> right;
    int right_width = 1;
    for (std::size_t i = 0; i < levels.size(); ++i) {
        horizontal.origin = {0, levels[i].height, 0};
        // Room for the label above narrow sections.
        right.push_back(draw(layers, horizontal, extents[i], scale,
                             fmt::format("{} y={:.2f} m", levels[i].name, levels[i].height)));
        right_width = std::max(right_width, right.back().width);
    }
    const int width = std::max(left.width + right_width + 3 * gap, 900);
    Image picture(width, settings.height + 30 + 3 * gap, paper_colour);
    paste(picture, left, gap, gap);
    int y = gap;
    for (const Image& image : right) {
        paste(picture, image, left.width + 2 * gap, y);
        y += image.height + gap;
    }
    paste(picture, legend(layers, width - 2 * gap), gap, picture.height - 30 - gap / 2);
    return picture;
}

}  // namespace ndg
