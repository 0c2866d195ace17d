// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/motion_display.h"

#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/deform/rest_cache.h"
#include "ndg/display/body_meshes.h"
#include "ndg/display/sample_frames.h"
#include "ndg/export/export_meshes.h"
#include "ndg/io/credits.h"

#include <filesystem>

namespace ndg {

namespace {

Points deformed_points(const DeformationSet& deformed, int sample_idx)
{
    if (interrupt_requested()) throw Interrupted("stopped; what was being shown was not written");
    return deformed.points(sample_idx);
}

}  // namespace

void MotionDisplay::add(Tool& tool)
{
    std::string formats;
    for (const ExportFormat& format : export_formats())
        formats += fmt::format("{}{} ({})", formats.empty() ? "" : ", ", format.extension, format.summary);
    tool.output("mesh", mesh,
                "the body in all frames with what lies inside, by extension " + formats +
                    "; where each frame is a file, its name holds the place of the number, out_{:04}.ply",
                false);
    tool.output("page", page, "HTML page that shows the body in motion in any browser", false);
    tool.output("picture", picture, "PNG picture of frames spread over the motion", false);
    tool.parameter("surface", surface, "what --mesh holds; parts: all, with each bone and muscle as a mesh of its own",
                   body_mesh_choices);
    tool.parameter("count", count, "frames on the picture", 1, 2000);
    tool.parameter("view", settings.view, "where the camera of the picture stands");
    tool.parameter("height", settings.height, "pixels of a body on the picture", 1, 8192);
    tool.parameter("volume-colours", settings.volume_colours,
                   "skin of meshes and picture coloured by change of volume");
    tool.parameter("colour-range", settings.colour_range, "change of volume shown in full colour", 1e-3, 10.0);
}

void MotionDisplay::check(const SampleIndex& samples, bool force) const
{
    if (!mesh.empty() || !page.empty())
        for (const SamplePair& pair : samples.pairs)
            require_input(pair.body_idx == samples.pairs[0].body_idx,
                          "--mesh and --page show one body, and these are samples of several: give --body");
    if (mesh.empty()) return;
    require_input(export_format(mesh).contents != Contents::volume,
                  "--mesh: {} holds prisms and tetrahedra, not meshes; export-scene writes it from --output", mesh);
    for (const std::string& file : exported_files(mesh, samples.size()))
        require_input(force || !std::filesystem::exists(file),
                      "--mesh: {} exists already, give --force to overwrite it", file);
}

void MotionDisplay::write(const SampleInputs& inputs, const DeformationSet& deformed, Deformer& deformer,
                          const std::string& credits) const
{
    const Template& body_template = inputs.body_template;
    const BodyPoser poser(body_template, deformed.posing);
    RestCache rest(body_template);
    if (!mesh.empty()) {
        const bool shows_anatomy = surface != "skin" && surface != "muscle_wrap" && surface != "bone_wrap";
        MeshSequence sequence = body_meshes(body_template, surface, settings, deformed.size(), [&](int frame_idx) {
            const SamplePair& pair = deformed.pairs[frame_idx];
            const Body& body = inputs.bodies.bodies[pair.body_idx];
            const PosedBody posed = poser.pose(body, inputs.poses.poses[pair.pose_idx], pair);
            const Points volume = deformed_points(deformed, frame_idx);
            const Points& at_rest = rest.anatomy(body);
            if (!shows_anatomy) return BodyFrame{&body, posed_geometry(posed, volume, at_rest)};
            return BodyFrame{&body, posed_geometry(posed, volume, deformer.anatomy(posed, at_rest, volume))};
        });
        std::vector<int> pose_indices;
        for (const SamplePair& pair : deformed.pairs) pose_indices.push_back(pair.pose_idx);
        if (deformed.size() > 1) sequence.frame_rate = shown_frame_rate(inputs.poses, pose_indices);
        sequence.credits = credits;
        export_meshes(mesh, sequence);
        fmt::print("{}: {} frames\n", mesh, deformed.size());
    }
    const std::vector<DeformationSet> files = {deformed};
    if (!page.empty()) {
        PageMotion motion = page_motion(inputs.bodies, inputs.poses, files, 0, 0);
        motion.credits = credits;
        motion.methods[0].volume = [&](int frame_idx) { return deformed_points(deformed, frame_idx); };
        motion.methods[0].anatomy = [&](const PosedBody& posed, const Points& at_rest, const Points& volume) {
            return deformer.anatomy(posed, at_rest, volume);
        };
        const PageFigures figures = write_page(page, poser, motion);
        fmt::print("{}: {} frames, every vertex within {:.2f} mm\n", page, motion.poses.size(),
                   1e3 * figures.largest_error);
    }
    if (!picture.empty()) {
        std::vector<SamplePair> shown;
        for (const int i : spread_indices(deformed.size(), count)) shown.push_back(deformed.pairs[i]);
        write_png(picture, frames_picture(poser, inputs.bodies, inputs.poses, files, shown, settings));
        add_png_credits(picture, credits);
        fmt::print("{}: {} frames\n", picture, shown.size());
    }
}

}  // namespace ndg
