// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/scene/contact_sheet.h"
#include "ndg/scene/gltf.h"
#include "ndg/scene/pictures.h"

#include <algorithm>
#include <iostream>
#include <numeric>

namespace {

using namespace ndg;

/// Which body in which shape: at rest, skinned to a pose, or a sample of a deformation file.
struct Selection {
    int body_idx = 0, pose_idx = -1, sample_idx = -1;
};

Selection select(const Selection& asked, const std::vector<DeformationSet>& files, const BodySet& bodies,
                 const PoseSet& poses)
{
    Selection selection = asked;
    if (asked.sample_idx >= 0) {
        require_input(files.size() == 1, "--sample {} needs exactly one --deformations file, not {}", asked.sample_idx,
                      files.size());
        require_input(asked.sample_idx < files[0].size(), "--sample {} lies outside the {} samples of the {} file",
                      asked.sample_idx, files[0].size(), files[0].method);
        selection.body_idx = files[0].pairs[std::size_t(asked.sample_idx)].body_idx;
        selection.pose_idx = files[0].pairs[std::size_t(asked.sample_idx)].pose_idx;
    }
    require_input(selection.body_idx >= 0 && selection.body_idx < int(bodies.bodies.size()),
                  "Body {} lies outside the {} bodies", selection.body_idx, bodies.bodies.size());
    require_input(selection.pose_idx < poses.size(), "Pose {} lies outside the {} poses of --poses", selection.pose_idx,
                  poses.size());
    return selection;
}

BodyGeometry geometry_of(const Selection& selection, const BodyPoser& poser, const BodySet& bodies,
                         const PoseSet& poses, const std::vector<DeformationSet>& files)
{
    const Body& body = bodies.bodies[std::size_t(selection.body_idx)];
    if (selection.pose_idx < 0) return rest_geometry(poser.body_template(), body);
    const PosedBody posed = poser.pose(body, poses.poses[selection.pose_idx]);
    if (selection.sample_idx < 0) return skinned_geometry(posed);
    return posed_geometry(posed, files[0].points(selection.sample_idx));
}

std::vector<Layer> scene_layers(const Template& body_template, const BodyGeometry& geometry)
{
    std::vector<Layer> layers = anatomy_layers(body_template, geometry);
    layers.push_back(bone_wrap_layer(body_template, geometry));
    layers.push_back(muscle_wrap_layer(body_template, geometry));
    layers.push_back(skin_layer(body_template, geometry));
    // So that what lies inside shows through.
    layers.back().opacity = 0.35f;
    layers[layers.size() - 2].opacity = 0.5f;
    return layers;
}

/// The first `count` poses, in the order they were sampled: the most different ones.
Image poses_picture(const BodyPoser& poser, const BodySet& bodies, int body_idx, const PoseSet& poses, int count,
                    const ContactSheetSettings& settings)
{
    require_input(body_idx < int(bodies.bodies.size()), "Body {} lies outside the {} bodies", body_idx,
                  bodies.bodies.size());
    std::vector<int> indices(std::size_t(std::min(count, poses.size())));
    std::iota(indices.begin(), indices.end(), 0);
    return contact_sheet(poser, bodies.bodies[std::size_t(body_idx)], poses, indices, settings);
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("export-scene", "Renders pictures of bodies and samples, and writes them as glTF scenes",
              "export-scene --template template.h5 --bodies bodies.h5 --body 3 --picture layers.png "
              "--picture-kind layers --glb body.glb");
    std::string template_path, bodies_path, poses_path, glb_path, picture_path;
    std::vector<std::string> deformation_paths;
    Selection asked;
    std::string view = "front", kind = "body", split = "test", colour = "plain";
    int count = 3;
    PictureSettings settings;
    ContactSheetSettings sheet;
    int height = 0;
    tool.input("template", template_path, "Template");
    tool.input("bodies", bodies_path, "Layered bodies");
    tool.input("poses", poses_path, "Poses, for --pose, --sample, frames and poses", false);
    tool.input("deformations", deformation_paths, "Samples or predictions; several for frames", false);
    tool.output("glb", glb_path, "Binary glTF scene of the body with its layers", false);
    tool.output("picture", picture_path, "PNG picture", false);
    tool.parameter("body", asked.body_idx, "Body index", 0, 1 << 30);
    tool.parameter("pose", asked.pose_idx, "Pose index, moved by linear blend skinning; -1: at rest", -1, 1 << 30);
    tool.parameter("sample", asked.sample_idx, "Sample of the deformation file; -1: none", -1, 1 << 30);
    tool.parameter("picture-kind", kind, "What the picture shows",
                   {"body", "layers", "cut", "frames", "bodies", "poses"});
    tool.parameter("view", view, "Where the camera stands", view_names());
    tool.parameter("colour", colour, "Skin in plain colour or by volume change", {"plain", "volume"});
    tool.parameter("colour-range", settings.colour_range, "Volume change shown in full colour", 1e-3, 10.0);
    tool.parameter("split", split, "Split the frames are taken from", split_names);
    tool.parameter("count", count, "Number of frames, bodies or poses shown", 1, 2000);
    tool.parameter("height", height, "Pixels of one body; 0: 1200, and 200 on a sheet of poses", 0, 8192);
    tool.parameter("supersampling", settings.samples_per_axis, "Rays along each side of a pixel", 1, 8);

    return tool.run(argc, argv, [&] {
        require_input(!glb_path.empty() || !picture_path.empty(), "Give --picture, --glb or both");
        settings.view = sheet.view = parse_view(view);
        sheet.samples_per_axis = settings.samples_per_axis;
        if (height > 0) settings.height = sheet.cell_height = height;
        settings.volume_colours = colour == "volume";
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        PoseSet poses;
        if (!poses_path.empty()) poses = read_poses(poses_path);
        std::vector<DeformationSet> files;
        for (const std::string& path : deformation_paths)
            files.push_back(open_deformations(path, body_template.num_volume_vertices()));
        const BodyPoser poser(body_template);

        if (!glb_path.empty() || kind == "body" || kind == "layers" || kind == "cut") {
            const Selection selection = select(asked, files, bodies, poses);
            const Body& body = bodies.bodies[std::size_t(selection.body_idx)];
            const BodyGeometry geometry = geometry_of(selection, poser, bodies, poses, files);
            if (!glb_path.empty()) {
                std::string credits;
                for (const Provenance::Input& file : tool.provenance().inputs)
                    if (!file.licences.empty() && credits.find(file.licences) == std::string::npos)
                        credits += (credits.empty() ? "" : "; ") + file.licences;
                write_glb(glb_path, scene_layers(body_template, geometry), credits);
                std::cout << glb_path << "\n";
            }
            if (picture_path.empty()) return;
            require_input(kind != "cut" || selection.pose_idx < 0, "Sections are of a body at rest; leave out --pose");
            if (kind == "body") write_png(picture_path, body_picture(body_template, body, geometry, settings));
            if (kind == "layers") write_png(picture_path, layers_picture(body_template, geometry, settings));
            if (kind == "cut") write_png(picture_path, sections_picture(body_template, body, settings));
        }
        if (picture_path.empty()) return;
        if (kind == "frames")
            write_png(picture_path, frames_picture(poser, bodies, poses, files, split, count, settings));
        if (kind == "bodies") write_png(picture_path, bodies_picture(body_template, bodies, count, settings));
        if (kind == "poses") write_png(picture_path, poses_picture(poser, bodies, asked.body_idx, poses, count, sheet));
        std::cout << picture_path << "\n";
    });
}
