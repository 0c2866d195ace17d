// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/pictures.h"

#include "ndg/core/error.h"
#include "ndg/scene/render.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

const Pixel paper_colour = {244, 245, 246};  // the renderer's background in 8 bits

Camera frame_body(const Points& points, View view, double heading, double aspect)
{
    return frame_points(points, view_direction(view, heading), aspect, 0.03);
}

/// Width to height of a body as the camera sees it, so that pictures are not wider than they must be.
double body_aspect(const Points& points, View view, double heading)
{
    const Camera camera = frame_points(points, view_direction(view, heading), 1.0, 0.0);
    const Eigen::VectorXd across = points * camera.right, upward = points * camera.up;
    const double aspect =
        (across.maxCoeff() - across.minCoeff()) / std::max(1e-9, upward.maxCoeff() - upward.minCoeff());
    return std::clamp(1.04 * aspect, 0.4, 2.0);
}

RenderSettings render_settings(const PictureSettings& settings, double aspect)
{
    RenderSettings result;
    result.height = settings.height;
    result.width = std::max(1, int(std::lround(aspect * settings.height)));
    result.samples_per_axis = settings.samples_per_axis;
    return result;
}

/// Index of the sample of `pair`, -1 if there is none.
int find_sample(const DeformationSet& file, const SamplePair& pair)
{
    for (int i = 0; i < file.size(); ++i) {
        const SamplePair& stored = file.pairs[std::size_t(i)];
        if (stored.body_idx == pair.body_idx && stored.pose_idx == pair.pose_idx) return i;
    }
    return -1;
}

}  // namespace

SceneSurface shown_skin(const Template& body_template, const Body& body, const BodyGeometry& geometry,
                        const PictureSettings& settings)
{
    return settings.volume_colours ? volume_change_surface(body_template, body, geometry, settings.colour_range)
                                   : skin_surface(body_template, geometry);
}

std::vector<int> spread_indices(int size, int count)
{
    std::vector<int> indices;
    const int num = std::min(size, count);
    for (int i = 0; i < num; ++i) indices.push_back(int((std::int64_t(2 * i + 1) * size) / (2 * num)));
    return indices;
}

Image body_picture(const Template& body_template, const Body& body, const BodyGeometry& geometry,
                   const PictureSettings& settings)
{
    const double aspect = body_aspect(geometry.skin_vertices, settings.view, geometry.heading);
    RenderSettings render_with = render_settings(settings, aspect);
    render_with.ground_height = geometry.skin_vertices.col(1).minCoeff();
    return render({shown_skin(body_template, body, geometry, settings)},
                  frame_body(geometry.skin_vertices, settings.view, geometry.heading, aspect), render_with);
}

Image layers_picture(const Template& body_template, const BodyGeometry& geometry, const PictureSettings& settings)
{
    const SceneSurface shell = skin_shell(body_template, geometry);
    const std::vector<SceneSurface> anatomy = anatomy_surfaces(body_template, geometry);  // bones, then muscles
    std::vector<std::vector<SceneSurface>> columns = {{skin_surface(body_template, geometry)},
                                                      {muscle_wrap_surface(body_template, geometry), shell},
                                                      {bone_wrap_surface(body_template, geometry), shell}};
    SheetLabels labels;
    labels.columns = {"skin", "muscle wrap", "bone wrap"};
    for (const SceneSurface& surface : anatomy) {
        const bool muscles = surface.name == "muscles" && anatomy.size() == 2;
        columns.push_back(muscles ? std::vector<SceneSurface>{anatomy[0], surface, shell}
                                  : std::vector<SceneSurface>{surface, shell});
        labels.columns.push_back(muscles ? "muscles and bones" : surface.name);
    }
    std::vector<Image> images;
    for (const View view : {View::front, View::back}) {
        const double aspect = body_aspect(geometry.skin_vertices, view, geometry.heading);
        const Camera camera = frame_body(geometry.skin_vertices, view, geometry.heading, aspect);
        RenderSettings render_with = render_settings(settings, aspect);
        render_with.ground_height = geometry.skin_vertices.col(1).minCoeff();
        for (const std::vector<SceneSurface>& surfaces : columns)
            images.push_back(render(surfaces, camera, render_with));
    }
    return tile_images(images, int(columns.size()), labels, paper_colour);
}

Image surface_picture(const SceneSurface& surface, View view, const PictureSettings& settings)
{
    const double aspect = body_aspect(surface.vertices, view, 0.0);
    return render({surface}, frame_body(surface.vertices, view, 0.0, aspect), render_settings(settings, aspect));
}

Image frames_picture(const BodyPoser& poser, const BodySet& bodies, const PoseSet& poses,
                     const std::vector<DeformationSet>& files, const std::string& split, int num_samples,
                     const PictureSettings& settings)
{
    require_input(!files.empty(), "A sheet of frames needs at least one deformation file");
    std::vector<SamplePair> pairs;
    for (int i = 0; i < files[0].size(); ++i)
        if (files[0].pair_splits[std::size_t(i)] == split) pairs.push_back(files[0].pairs[std::size_t(i)]);
    require_input(!pairs.empty(), "The {} file has no sample of split {}", files[0].method, split);
    std::vector<SamplePair> shown;
    for (const int i : spread_indices(int(pairs.size()), num_samples)) shown.push_back(pairs[i]);
    return frames_picture(poser, bodies, poses, files, shown, settings);
}

Image frames_picture(const BodyPoser& poser, const BodySet& bodies, const PoseSet& poses,
                     const std::vector<DeformationSet>& files, const std::vector<SamplePair>& pairs,
                     const PictureSettings& settings)
{
    require_input(!files.empty() && !pairs.empty(), "A sheet of frames needs a deformation file and a sample at least");
    SheetLabels labels;
    for (const DeformationSet& file : files) labels.columns.push_back(file.method);
    if (settings.volume_colours)
        labels.footer =
            fmt::format("volume change: blue -{0:.0f} % or less, red +{0:.0f} % or more", 100 * settings.colour_range);
    std::vector<Image> images;
    double aspect = 0;  // of all cells: that of the widest row
    std::vector<std::vector<BodyGeometry>> rows;
    for (const SamplePair& pair : pairs) {
        require_input(pair.body_idx >= 0 && pair.body_idx < int(bodies.bodies.size()) && pair.pose_idx >= 0 &&
                          pair.pose_idx < poses.size(),
                      "A sample names body {} and pose {}, but there are {} bodies and {} poses", pair.body_idx,
                      pair.pose_idx, bodies.bodies.size(), poses.size());
        rows.emplace_back();
        const PosedBody posed = poser.pose(bodies.bodies[pair.body_idx], poses.poses[pair.pose_idx], pair);
        for (const DeformationSet& file : files) {
            const int sample = find_sample(file, pair);
            require_input(sample >= 0, "The {} file has no sample of body {} in pose {}", file.method, pair.body_idx,
                          pair.pose_idx);
            rows.back().push_back(posed_geometry(posed, file.points(sample)));
        }
        labels.rows.push_back(fmt::format("body {} pose {}", pair.body_idx, pair.pose_idx));
        const BodyGeometry& first = rows.back().front();
        aspect = std::max(aspect, body_aspect(first.skin_vertices, settings.view, first.heading));
    }
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const Eigen::Index num_vertices = rows[row].front().skin_vertices.rows();
        Points all(num_vertices * Eigen::Index(files.size()), 3);
        for (std::size_t k = 0; k < files.size(); ++k)
            all.middleRows(Eigen::Index(k) * num_vertices, num_vertices) = rows[row][k].skin_vertices;
        const Camera camera = frame_body(all, settings.view, rows[row].front().heading, aspect);
        RenderSettings render_with = render_settings(settings, aspect);
        render_with.ground_height = all.col(1).minCoeff();
        const Body& body = bodies.bodies[pairs[row].body_idx];
        for (const BodyGeometry& geometry : rows[row])
            images.push_back(
                render({shown_skin(poser.body_template(), body, geometry, settings)}, camera, render_with));
    }
    return tile_images(images, int(files.size()), labels, paper_colour);
}

Image bodies_picture(const Template& body_template, const BodySet& bodies, int max_bodies,
                     const PictureSettings& settings)
{
    require_input(!bodies.bodies.empty() && max_bodies >= 1, "There is no body to show");
    const std::vector<int> indices = spread_indices(int(bodies.bodies.size()), max_bodies);
    // One camera that frames the union, so that bodies can be compared in size.
    const Eigen::Index num_vertices = body_template.rest.skin_vertices.rows();
    Points all(num_vertices * Eigen::Index(indices.size()), 3);
    for (std::size_t k = 0; k < indices.size(); ++k)
        all.middleRows(Eigen::Index(k) * num_vertices, num_vertices) =
            bodies.bodies[std::size_t(indices[k])].skin_vertices;
    const double aspect = body_aspect(all, settings.view, 0.0);
    const Camera camera = frame_body(all, settings.view, 0.0, aspect);
    RenderSettings render_with = render_settings(settings, aspect);
    std::vector<Image> images;
    for (const int index : indices) {
        const Body& body = bodies.bodies[std::size_t(index)];
        render_with.ground_height = body.skin_vertices.col(1).minCoeff();
        images.push_back(
            render({skin_surface(body_template, rest_geometry(body_template, body))}, camera, render_with));
    }
    const int columns =
        std::min(int(images.size()), std::max(2, int(std::ceil(std::sqrt(2.0 * double(images.size()))))));
    return tile_images(images, columns,
                       {fmt::format("{} of {} bodies", images.size(), bodies.bodies.size()), {}, {}, ""}, paper_colour);
}

}  // namespace ndg
