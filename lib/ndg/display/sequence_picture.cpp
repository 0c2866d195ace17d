// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/sequence_picture.h"

#include "ndg/core/error.h"
#include "ndg/scene/render.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

/// Width of a frame by its height: room for what comes near a standing person.
constexpr double frame_shape = 0.75;
constexpr int occlusion_rays = 24;

std::vector<SceneSurface> surfaces_of(const MeshSequence& sequence, const std::vector<MeshFrame>& frame)
{
    std::vector<SceneSurface> surfaces;
    for (std::size_t i = 0; i < sequence.meshes.size(); ++i) {
        const ExportedMesh& mesh = sequence.meshes[i];
        SceneSurface surface;
        surface.name = mesh.name;
        surface.vertices = frame[i].vertices;
        surface.triangles = mesh.triangles;
        surface.colour = mesh.colour;
        surface.opacity = mesh.opacity;
        surface.gloss = mesh.gloss;
        surface.two_sided = mesh.two_sided;
        surface.vertex_colours = frame[i].colours;
        surfaces.push_back(std::move(surface));
    }
    return surfaces;
}

}  // namespace

void describe(OptionList& list, SequencePictureOptions& options)
{
    list.add("picture-frames", options.frames, "frames in the picture, from the first to the last", 1, 100);
    list.add("picture-view", options.view, "from where the picture is seen");
    list.add("picture-height", options.height, "pixels of one frame of the picture", 50, 4000);
}

Image sequence_picture(const MeshSequence& sequence, const SequencePictureOptions& options,
                       const std::vector<std::string>& given_labels)
{
    check_options(options);
    require_input(!sequence.meshes.empty() && sequence.num_frames > 0, "a sequence of {} meshes and {} frames",
                  sequence.meshes.size(), sequence.num_frames);
    const int count = std::min(options.frames, sequence.num_frames);
    std::vector<std::vector<SceneSurface>> frames;
    SheetLabels labels;
    Eigen::Index num_points = 0;
    for (int k = 0; k < count; ++k) {
        const int frame =
            count == 1 ? 0 : static_cast<int>(std::lround(double(k) * (sequence.num_frames - 1) / (count - 1)));
        frames.push_back(surfaces_of(sequence, sequence.frame(frame)));
        labels.columns.push_back(fmt::format("{:.2f} s", frame / sequence.frame_rate));
        num_points += frames.back()[0].vertices.rows();
    }
    Points body(num_points, 3);
    Eigen::Index row = 0;
    for (const auto& surfaces : frames) {
        body.middleRows(row, surfaces[0].vertices.rows()) = surfaces[0].vertices;
        row += surfaces[0].vertices.rows();
    }
    RenderSettings settings;
    settings.height = options.height;
    settings.width = std::max(16, static_cast<int>(std::lround(frame_shape * options.height)));
    settings.occlusion_rays = occlusion_rays;
    if (!given_labels.empty()) labels.columns = given_labels;
    const Camera camera = frame_points(body, view_direction(options.view), frame_shape);
    std::vector<Image> images;
    for (const auto& surfaces : frames) images.push_back(render(surfaces, camera, settings));
    return tile_images(images, count, labels);
}

}  // namespace ndg
