// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/scene/pictures.h"
#include "ndg/scene/section.h"
#include "ndg/scene/text.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {
namespace {

const Pixel paper_colour = {244, 245, 246};

constexpr int label_height = 24, legend_height = 30, legend_width = 1060, gap = 10;  // pixels

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
std::vector<SceneSurface> section_surfaces(const Template& body_template, const BodyGeometry& geometry)
{
    SceneSurface skin = skin_surface(body_template, geometry);
    skin.colour = {0.90f, 0.90f, 0.90f};
    SceneSurface fat = closed_surface(skin_wrap_surface(body_template, geometry));
    fat.colour = {0.95f, 0.80f, 0.50f};
    SceneSurface muscle = closed_surface(muscle_wrap_surface(body_template, geometry));
    muscle.colour = {0.80f, 0.36f, 0.32f};
    SceneSurface core = closed_surface(bone_wrap_surface(body_template, geometry));
    core.colour = {0.72f, 0.74f, 0.78f};
    std::vector<SceneSurface> surfaces = {skin, fat, muscle, core};
    for (SceneSurface& surface : anatomy_surfaces(body_template, geometry)) {
        surface.colour =
            surface.name == "bones" ? Eigen::Vector3f(0.98f, 0.96f, 0.88f) : Eigen::Vector3f(0.60f, 0.16f, 0.16f);
        // Bones over muscles, whatever order the template stores them in.
        if (surface.name == "bones")
            surfaces.push_back(surface);
        else
            surfaces.insert(surfaces.begin() + 4, surface);
    }
    return surfaces;
}

struct Extent {
    Eigen::Vector2d low, high;
};

/// Bounding box of points in plane coordinates (metres along right and up).
Extent plane_extent(const Points& points, const SectionPlane& plane)
{
    const Points centred = points.rowwise() - plane.origin.transpose();
    const Eigen::VectorXd across = centred * plane.right, upward = centred * plane.up;
    return {{across.minCoeff(), upward.minCoeff()}, {across.maxCoeff(), upward.maxCoeff()}};
}

/// Bounding box of a section.
Extent section_extent(const SceneSurface& surface, const SectionPlane& plane)
{
    const double far = std::numeric_limits<double>::infinity();
    Extent extent{{far, far}, {-far, -far}};
    for (const SectionSegment& segment : section_segments(surface.vertices, surface.triangles, plane))
        for (const Eigen::Vector2d& point : {segment.begin, segment.end}) {
            extent.low = extent.low.cwiseMin(point);
            extent.high = extent.high.cwiseMax(point);
        }
    return extent;
}

/// The section with its label above.
Image draw(const std::vector<SceneSurface>& surfaces, const SectionPlane& plane, const Extent& extent,
           double pixels_per_metre, const std::string& label)
{
    SectionSettings settings;
    const Eigen::Vector2d size = (extent.high - extent.low) * pixels_per_metre;
    settings.centre = 0.5 * (extent.low + extent.high);
    settings.pixels_per_metre = pixels_per_metre;
    settings.width = std::max(text_width(label, 2), int(std::ceil(size.x())) + 4);
    settings.height = int(std::ceil(size.y())) + 4;
    Image image(settings.width, settings.height + label_height, paper_colour);
    paste(image, section_image(surfaces, plane, settings), 0, label_height);
    draw_text(image, label, 0, 0, 2, {45, 52, 60});
    return image;
}

Image legend(const std::vector<SceneSurface>& surfaces, int width)
{
    Image image(width, legend_height, paper_colour);
    const std::vector<std::pair<std::string, std::string>> names = {{"skin", "surface only"},
                                                                    {"skin_wrap", "fat layer"},
                                                                    {"muscle_wrap", "muscle layer"},
                                                                    {"bone_wrap", "inside of bone wrap"},
                                                                    {"bones", "bones"},
                                                                    {"muscles", "muscles"}};
    int x = 8;
    for (const SceneSurface& surface : surfaces) {
        std::string text = surface.name;
        for (const auto& [name, description] : names)
            if (surface.name == name) text = description;
        const Image swatch(14, 14, pixel_from_linear(linear_from_srgb(surface.colour)));
        paste(image, swatch, x, 8);
        draw_text(image, text, x + 20, 8, 2, {45, 52, 60});
        x += 20 + text_width(text, 2) + 22;
    }
    return image;
}

/// Axes of the three planes, as seen.
SectionPlane plane_of(SectionKind kind)
{
    SectionPlane plane;
    if (kind == SectionKind::sagittal) plane.right = Eigen::Vector3d::UnitZ();
    if (kind == SectionKind::horizontal) plane.up = -Eigen::Vector3d::UnitZ();
    return plane;
}

struct LabelledPlane {
    std::string label;
    SectionKind kind;
    SectionPlane plane;
};

/// The joint that a plane goes through. Throws InputError for one the skeleton lacks.
int joint_of(const Skeleton& skeleton, const SectionChoice& choice)
{
    const auto& names = skeleton.joint_names;
    std::string name = choice.joint;
    if (name.empty())
        name = choice.kind == SectionKind::coronal      ? "left_upper_arm"
               : choice.kind == SectionKind::horizontal ? "spine_4"
                                                        : "pelvis";
    require_input(std::find(names.begin(), names.end(), name) != names.end(), "there is no joint '{}'", name);
    return skeleton.joint(name);
}

/// The plane that is asked for, of a body at rest; the sagittal one for all.
LabelledPlane plane_through_joint(const Skeleton& skeleton, const Body& body, const SectionChoice& choice)
{
    const SectionKind kind = choice.kind == SectionKind::all ? SectionKind::sagittal : choice.kind;
    SectionPlane plane = plane_of(kind);
    plane.origin = body.joint_positions.row(joint_of(skeleton, choice)).transpose();
    plane.origin[kind == SectionKind::sagittal ? 0 : kind == SectionKind::coronal ? 2 : 1] += choice.offset;
    return {to_name(kind), kind, plane};
}

/// The same where the pose took it.
LabelledPlane posed_plane(const PosedBody& posed, const SectionChoice& choice)
{
    const Skeleton& skeleton = posed.body_template().skeleton;
    LabelledPlane cut = plane_through_joint(skeleton, posed.body(), choice);
    const Eigen::Isometry3d& world_from_rest = posed.world_from_rest()[joint_of(skeleton, choice)];
    cut.plane.origin = world_from_rest * cut.plane.origin;
    cut.plane.right = world_from_rest.linear() * cut.plane.right;
    cut.plane.up = world_from_rest.linear() * cut.plane.up;
    return cut;
}

/// The planes of a body, from the top of its column down.
std::vector<LabelledPlane> section_planes(const Skeleton& skeleton, const Body& body, const SectionChoice& choice)
{
    std::vector<LabelledPlane> planes = {plane_through_joint(skeleton, body, choice)};
    if (choice.kind != SectionKind::all) return planes;
    for (const Level& level : section_levels(skeleton, body)) {
        if (level.name == "upper arm" || level.name == "thigh") continue;
        SectionPlane plane = plane_of(SectionKind::horizontal);
        plane.origin = {0.0, level.height, 0.0};
        planes.push_back({level.name, SectionKind::horizontal, plane});
    }
    return planes;
}

/// Half the breadth of the trunk about the height `y`: of the skin that hangs on the trunk's joints or the thighs'.
double trunk_half_breadth(const Template& body_template, const Body& body, double y)
{
    constexpr double band = 0.03;
    double half = 0.0;
    for (Eigen::Index v = 0; v < body.skin_vertices.rows(); ++v) {
        if (std::abs(body.skin_vertices(v, 1) - y) > band) continue;
        int most = 0;
        body_template.skin_weights.weights.row(v).maxCoeff(&most);
        const std::string& joint = body_template.skeleton.joint_names[body_template.skin_weights.joints(v, most)];
        if (joint == "pelvis" || joint.rfind("spine_", 0) == 0 || joint.find("_thigh") != std::string::npos ||
            joint.find("_clavicle") != std::string::npos)
            half = std::max(half, std::abs(body.skin_vertices(v, 0)));
    }
    return half;
}

/// One below the other, centred; `heights` of the cells, empty: of the images.
Image stacked(const std::vector<Image>& images, const std::vector<int>& heights)
{
    const auto height = [&](std::size_t k) { return gap + (heights.empty() ? images[k].height : heights[k]); };
    int width = 0, total = 0;
    for (std::size_t k = 0; k < images.size(); ++k) {
        width = std::max(width, images[k].width);
        total += height(k);
    }
    Image column(width, total, paper_colour);
    int y = 0;
    for (std::size_t k = 0; k < images.size(); ++k) {
        paste(column, images[k], (width - images[k].width) / 2, y);
        y += height(k);
    }
    return column;
}

/// Columns with the legend of `surfaces` below.
Image side_by_side(const std::vector<Image>& columns, const std::vector<SceneSurface>& surfaces)
{
    int width = gap, height = 0;
    for (const Image& column : columns) {
        width += column.width + gap;
        height = std::max(height, column.height);
    }
    const Image key = legend(surfaces, std::max(width, legend_width));
    Image picture(key.width, height + gap + legend_height, paper_colour);
    int x = gap;
    for (const Image& column : columns) {
        paste(picture, column, x, gap);
        x += column.width + gap;
    }
    paste(picture, key, 0, height + gap);
    return picture;
}

}  // namespace

Image section_sheet(const Template& body_template, const BodySet& bodies, const std::vector<int>& body_indices,
                    const SectionChoice& choice, const PictureSettings& settings)
{
    require_input(!body_indices.empty(), "There is no body to show");
    double tallest = 0.0;
    for (const int b : body_indices) {
        const auto heights = bodies.bodies[b].skin_vertices.col(1);
        tallest = std::max(tallest, heights.maxCoeff() - heights.minCoeff());
    }
    const double scale = settings.height / tallest;
    std::vector<std::vector<Image>> columns;
    std::vector<SceneSurface> surfaces;
    for (const int b : body_indices) {
        const Body& body = bodies.bodies[b];
        surfaces = section_surfaces(body_template, rest_geometry(body_template, body));
        std::vector<Image> column;
        for (const LabelledPlane& cut : section_planes(body_template.skeleton, body, choice)) {
            Extent extent = section_extent(surfaces[0], cut.plane);
            require_input(extent.low.x() < extent.high.x(), "the {} plane misses body {}", cut.label, body.name);
            if (cut.kind == SectionKind::horizontal) {
                const double half = trunk_half_breadth(body_template, body, cut.plane.origin.y()) + 0.01;
                extent.low.x() = std::max(extent.low.x(), -half);
                extent.high.x() = std::min(extent.high.x(), half);
            }
            const std::string label = column.empty() ? fmt::format("{} {}", body.name, cut.label) : cut.label;
            column.push_back(draw(surfaces, cut.plane, extent, scale, label));
        }
        columns.push_back(std::move(column));
    }
    // Sections of one body stand beside each other, of several below each other and in rows.
    if (columns.size() == 1 && columns[0].size() > 1) {
        columns.emplace_back(columns[0].begin() + 1, columns[0].end());
        columns[0].resize(1);
        return side_by_side({stacked(columns[0], {}), stacked(columns[1], {})}, surfaces);
    }
    std::vector<int> heights(columns.front().size(), 0);
    for (const std::vector<Image>& column : columns)
        for (std::size_t r = 0; r < heights.size(); ++r) heights[r] = std::max(heights[r], column[r].height);
    std::vector<Image> stacks;
    for (const std::vector<Image>& column : columns) stacks.push_back(stacked(column, heights));
    return side_by_side(stacks, surfaces);
}

ClipPlane posed_cut(const PosedBody& posed, const SectionChoice& choice)
{
    const LabelledPlane cut = posed_plane(posed, choice);
    // Sagittal sections are seen from the right, the others from where the normal points.
    const Eigen::Vector3d seen_from = cut.plane.right.cross(cut.plane.up);
    return {cut.plane.origin, cut.kind == SectionKind::sagittal ? Eigen::Vector3d(-seen_from) : seen_from};
}

Image posed_section_picture(const PosedBody& posed, const BodyGeometry& geometry, const SectionChoice& choice,
                            const PictureSettings& settings)
{
    const Template& body_template = posed.body_template();
    const Skeleton& skeleton = body_template.skeleton;
    const int joint = joint_of(skeleton, choice);
    const LabelledPlane cut = posed_plane(posed, choice);
    const SectionPlane& plane = cut.plane;
    const std::vector<SceneSurface> surfaces = section_surfaces(body_template, geometry);
    const Extent extent = section_extent(surfaces[0], plane);
    require_input(extent.low.x() < extent.high.x(), "the {} plane misses body {}", cut.label, posed.body().name);
    const std::string label = fmt::format("{} {} of {}", posed.body().name, cut.label, skeleton.joint_names[joint]);
    const double scale = settings.height / (extent.high - extent.low).maxCoeff();
    return side_by_side({draw(surfaces, plane, extent, scale, label)}, surfaces);
}

Image sections_picture(const Template& body_template, const Body& body, const PictureSettings& settings)
{
    const BodyGeometry geometry = rest_geometry(body_template, body);
    const std::vector<SceneSurface> surfaces = section_surfaces(body_template, geometry);
    const Skeleton& skeleton = body_template.skeleton;

    // Frontal section: the body faces the reader, its left side on the right hand as in the front view.
    SectionPlane frontal;
    frontal.origin = body.joint_positions.row(skeleton.joint("left_upper_arm")).transpose();
    frontal.origin.x() = 0;
    const Extent frontal_extent = plane_extent(body.skin_vertices, frontal);
    const double frontal_scale = (settings.height - label_height) / (frontal_extent.high.y() - frontal_extent.low.y());
    const Image left = draw(surfaces, frontal, frontal_extent, frontal_scale, "frontal");

    // Horizontal sections, seen from above with the front of the body at the bottom; one scale and one middle for all.
    const std::vector<Level> levels = section_levels(skeleton, body);
    SectionPlane horizontal;
    horizontal.right = Eigen::Vector3d::UnitX();
    horizontal.up = -Eigen::Vector3d::UnitZ();
    std::vector<Extent> extents;
    double total_depth = 0, half_width = 0;
    for (const Level& level : levels) {
        horizontal.origin = {0, level.height, 0};
        const Extent extent = section_extent(surfaces[0], horizontal);
        require(extent.low.x() < extent.high.x(), "The {} section at {:.3f} m misses the skin", level.name,
                level.height);
        extents.push_back(extent);
        total_depth += extent.high.y() - extent.low.y();
        half_width = std::max({half_width, -extent.low.x(), extent.high.x()});
    }
    const double room = settings.height - double(levels.size()) * (label_height + gap + 4);
    const double scale = std::min(std::max(room, 50.0) / total_depth, 0.55 * settings.height / half_width);
    std::vector<Image> right;
    for (std::size_t i = 0; i < levels.size(); ++i) {
        horizontal.origin = {0, levels[i].height, 0};
        extents[i].low.x() = -half_width;
        extents[i].high.x() = half_width;
        right.push_back(draw(surfaces, horizontal, extents[i], scale,
                             fmt::format("{}, y = {:.2f} m", levels[i].name, levels[i].height)));
    }
    const Image key = legend(surfaces, left.width + right.front().width + gap);
    int height = left.height, y = gap;
    for (const Image& image : right) y += image.height + gap;
    height = std::max(height, y);
    Image picture(key.width + 2 * gap, height + legend_height + 2 * gap, paper_colour);
    paste(picture, left, gap, gap);
    y = gap;
    for (const Image& image : right) {
        paste(picture, image, left.width + 2 * gap, y);
        y += image.height + gap;
    }
    paste(picture, key, gap, picture.height - legend_height - gap / 2);
    return picture;
}

}  // namespace ndg
