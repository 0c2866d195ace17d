// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/contact_sheet.h"

#include "ndg/core/error.h"
#include "ndg/scene/render.h"
#include "ndg/scene/text.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

const Pixel paper_colour = {244, 245, 246}, ink = {45, 52, 60}, soft_ink = {110, 118, 126};
constexpr int number_scale = 2, caption_scale = 1, gap = 2;
constexpr int sheet_gap = 12;  // of tile_images

/// One pose as it is drawn.
struct Thumbnail {
    BodyGeometry geometry;
    Camera camera;
    double width = 0, height = 0;  ///< m, as the camera sees it
};

Thumbnail make_thumbnail(const BodyPoser& poser, const Body& body, const Pose& pose, View view)
{
    Thumbnail result;
    const PosedBody posed = poser.pose(body, pose);
    result.geometry.skin_vertices = posed.skinned_skin();
    const Eigen::Vector3d forward = posed.world_from_rest()[0].linear().col(2);
    // A body lying down has no heading.
    if (std::hypot(forward.x(), forward.z()) > 0.3) result.geometry.heading = std::atan2(forward.x(), forward.z());
    result.camera =
        frame_points(result.geometry.skin_vertices, view_direction(view, result.geometry.heading), 1.0, 0.0);
    const Eigen::VectorXd across = result.geometry.skin_vertices * result.camera.right,
                          upward = result.geometry.skin_vertices * result.camera.up;
    result.width = across.maxCoeff() - across.minCoeff();
    result.height = upward.maxCoeff() - upward.minCoeff();
    return result;
}

/// As much of a text as fits, its end kept: that is where frame numbers stand.
std::string fitted(const std::string& text, int scale, int width)
{
    std::string result = text;
    while (result.size() > 1 && text_width(result, scale) > width) result.erase(0, 1);
    return result;
}

}  // namespace

Image contact_sheet(const BodyPoser& poser, const Body& body, const PoseSet& poses,
                    const std::vector<int>& pose_indices, const ContactSheetSettings& settings)
{
    require_input(!pose_indices.empty(), "There is no pose to show");
    std::vector<Thumbnail> thumbnails;
    double width = 0.1, height = 0.1;
    for (const int idx : pose_indices) {
        require_input(idx >= 0 && idx < poses.size(), "Pose {} lies outside the {} poses", idx, poses.size());
        thumbnails.push_back(make_thumbnail(poser, body, poses.poses[std::size_t(idx)], settings.view));
        width = std::max(width, thumbnails.back().width);
        height = std::max(height, thumbnails.back().height);
    }
    const int caption = text_height(caption_scale) + 2 * gap;
    RenderSettings render_with;
    render_with.height = std::max(16, settings.cell_height - caption);
    // Not narrower than a short caption.
    const double shape = std::clamp(width / height, 0.4, 2.0);
    render_with.width = std::max(16, static_cast<int>(std::lround(render_with.height * shape)));
    render_with.samples_per_axis = settings.samples_per_axis;
    render_with.occlusion_rays = 24;
    const double aspect = double(render_with.width) / render_with.height;
    const double scale = 1.04 * std::max(height, width / aspect);

    std::vector<Image> cells;
    for (std::size_t k = 0; k < thumbnails.size(); ++k) {
        Thumbnail& thumbnail = thumbnails[k];
        thumbnail.camera.image_height = scale;
        const int idx = pose_indices[k];
        Image cell(render_with.width, render_with.height + caption, paper_colour);
        paste(cell, render({skin_layer(poser.body_template(), thumbnail.geometry)}, thumbnail.camera, render_with), 0,
              0);
        draw_text(cell, std::to_string(idx), gap, gap, number_scale, ink);
        const std::string& clip = poses.clip_names[std::size_t(poses.clip_idx[std::size_t(idx)])];
        const std::string text =
            fitted(clip + " " + std::to_string(poses.frame_idx[std::size_t(idx)]), caption_scale, cell.width);
        draw_text(cell, text, (cell.width - text_width(text, caption_scale)) / 2, render_with.height + gap,
                  caption_scale, soft_ink);
        cells.push_back(std::move(cell));
    }
    const double cell_width = cells.front().width + sheet_gap, cell_height = cells.front().height + sheet_gap;
    int columns = settings.columns;
    if (columns == 0)
        columns = static_cast<int>(std::ceil(std::sqrt(1.5 * double(cells.size()) * cell_height / cell_width)));
    columns = std::clamp(columns, 1, static_cast<int>(cells.size()));
    SheetLabels labels;
    labels.title = fmt::format("{} of {} poses", cells.size(), poses.size());
    return tile_images(cells, columns, labels, paper_colour);
}

}  // namespace ndg
