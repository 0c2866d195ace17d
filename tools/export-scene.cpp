// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/display/body_meshes.h"
#include "ndg/display/body_rig.h"
#include "ndg/display/body_volume.h"
#include "ndg/display/sample_frames.h"
#include "ndg/export/export_meshes.h"
#include "ndg/io/credits.h"
#include "ndg/scene/contact_sheet.h"
#include "ndg/scene/error_pictures.h"
#include "ndg/scene/pictures.h"
#include "ndg/scene/video.h"
#include "ndg/scene/video_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <numeric>

namespace {

using namespace ndg;

/// Which body in which shape: at rest, skinned to a pose, or a sample of a deformation file.
struct Selection {
    int body_idx = 0, pose_idx = -1, sample_idx = -1;
};

/// What is chosen from.
struct Inputs {
    const BodyPoser& poser;
    const BodySet& bodies;
    const PoseSet& poses;
    const std::vector<DeformationSet>& files;
};

Selection select(const Selection& asked, const Inputs& inputs)
{
    Selection selection = asked;
    if (asked.sample_idx >= 0) {
        require_input(inputs.files.size() == 1, "--sample {} needs exactly one --deformations file, not {}",
                      asked.sample_idx, inputs.files.size());
        const DeformationSet& file = inputs.files[0];
        require_input(asked.sample_idx < file.size(), "--sample {} lies outside the {} samples of the {} file",
                      asked.sample_idx, file.size(), file.method);
        selection.body_idx = file.pairs[asked.sample_idx].body_idx;
        selection.pose_idx = file.pairs[asked.sample_idx].pose_idx;
    }
    require_input(selection.body_idx >= 0 && selection.body_idx < int(inputs.bodies.bodies.size()),
                  "Body {} lies outside the {} bodies", selection.body_idx, inputs.bodies.bodies.size());
    require_input(selection.pose_idx < inputs.poses.size(), "Pose {} lies outside the {} poses of --poses",
                  selection.pose_idx, inputs.poses.size());
    return selection;
}

BodyGeometry geometry_of(const Selection& selection, const Inputs& inputs)
{
    const Body& body = inputs.bodies.bodies[selection.body_idx];
    if (selection.pose_idx < 0) return rest_geometry(inputs.poser.body_template(), body);
    const PosedBody posed = inputs.poser.pose(body, inputs.poses.poses[selection.pose_idx]);
    if (selection.sample_idx < 0) return skinned_geometry(posed);
    return posed_geometry(posed, inputs.files[0].points(selection.sample_idx));
}

/// How many samples of the file, or poses, there are from `asked` on; 1 for a body at rest.
int remaining_frames(const Selection& asked, const PoseSet& poses, const std::vector<DeformationSet>& files)
{
    if (asked.sample_idx >= 0) return std::max(1, (files.size() == 1 ? files[0].size() : 0) - asked.sample_idx);
    return asked.pose_idx < 0 ? 1 : std::max(1, poses.size() - asked.pose_idx);
}

/// `num_frames` poses or samples from `asked` on.
std::vector<Selection> select_frames(const Selection& asked, int num_frames, const Inputs& inputs)
{
    require_input(num_frames == 1 || asked.pose_idx >= 0 || asked.sample_idx >= 0,
                  "--frames {} needs --pose or --sample to start from", num_frames);
    std::vector<Selection> frames;
    for (int k = 0; k < num_frames; ++k) {
        Selection selection = asked;
        (asked.sample_idx >= 0 ? selection.sample_idx : selection.pose_idx) += k;
        frames.push_back(select(selection, inputs));
    }
    return frames;
}

/// Where the inputs stand, for formats that refer to them.
struct InputPaths {
    std::string body_template, bodies;
    std::vector<std::string> deformations;
};

/// One frame's volume, and where it stands on disk.
BodyVolume volume_of(const Selection& selection, const Inputs& inputs, const InputPaths& paths,
                     const DeformationSet* reference)
{
    BodyVolume shown;
    shown.body = &inputs.bodies.bodies[selection.body_idx];
    const std::size_t num_vertices = std::size_t(shown.body->volume_vertices.rows());
    if (selection.pose_idx < 0) {
        shown.volume_vertices = shown.body->volume_vertices;
        shown.interior_vertices = shown.body->interior_vertices;
        shown.stored = {paths.bodies,
                        "/bodies/volume_vertices",
                        {inputs.bodies.bodies.size(), num_vertices, 3},
                        selection.body_idx};
        return shown;
    }
    const PosedBody posed = inputs.poser.pose(*shown.body, inputs.poses.poses[selection.pose_idx]);
    shown.interior_vertices = posed.bone_interior();
    if (selection.sample_idx < 0) {
        shown.volume_vertices = posed.skinned_volume();
        return shown;
    }
    const DeformationSet& file = inputs.files[0];
    shown.volume_vertices = file.points(selection.sample_idx);
    shown.stored = {paths.deformations[0],
                    "/deformations/vertices",
                    {file.num_slices(), num_vertices, 3},
                    int(file.first_slice(selection.sample_idx))};
    if (reference == nullptr) return shown;
    const SamplePair& pair = file.pairs[selection.sample_idx];
    const auto found = std::find(reference->pairs.begin(), reference->pairs.end(), pair);
    require_input(found != reference->pairs.end(), "the --reference file has no sample of {}", describe(pair));
    shown.reference = reference->points(int(found - reference->pairs.begin()));
    return shown;
}

/// Of the layers, as the tool that made the samples says in its config.
LayerStiffness stiffness_of(const DeformationSet& file)
{
    LayerStiffness stiffness;
    const nlohmann::json configs = nlohmann::json::parse(file.file->file().attribute("config"));
    for (const nlohmann::json& config : configs) {
        stiffness.young_muscle = config.value("young_muscle", stiffness.young_muscle);
        stiffness.young_fat = config.value("young_fat", stiffness.young_fat);
    }
    return stiffness;
}

/// What --mesh writes. Keeps references to all but the frames.
MeshSequence mesh_sequence(const std::vector<Selection>& frames, const std::string& surface,
                           const PictureSettings& settings, const Inputs& inputs, const InputPaths& paths,
                           const DeformationSet* reference, Contents contents)
{
    const Template& body_template = inputs.poser.body_template();
    MeshSequence sequence;
    if (contents == Contents::volume) {
        sequence.num_frames = int(frames.size());
        sequence.volume = body_volume(
            body_template, paths.body_template, inputs.files.empty() ? LayerStiffness() : stiffness_of(inputs.files[0]),
            [=, &inputs, &paths](int frame_idx) { return volume_of(frames[frame_idx], inputs, paths, reference); });
    } else {
        sequence = body_meshes(body_template, surface, settings, int(frames.size()), [frames, &inputs](int frame_idx) {
            const Selection& selection = frames[frame_idx];
            return BodyFrame{&inputs.bodies.bodies[selection.body_idx], geometry_of(selection, inputs)};
        });
    }
    std::vector<int> pose_indices;
    for (const Selection& frame : frames) pose_indices.push_back(frame.pose_idx);
    if (frames.size() > 1) sequence.frame_rate = shown_frame_rate(inputs.poses, pose_indices);
    return sequence;
}

/// Puts the skin of a sequence on its skeleton; the sequence then has clips. Returns how near it comes.
BodyRig add_rig(MeshSequence& sequence, const std::vector<Selection>& frames, const Inputs& inputs,
                const RigOptions& options)
{
    const auto skin = std::find_if(sequence.meshes.begin(), sequence.meshes.end(),
                                   [](const ExportedMesh& mesh) { return mesh.name == "skin"; });
    require_input(skin != sequence.meshes.end(), "--rig moves the skin: --surface must be skin, all or parts");
    require_input(options.kind == RigKind::skinning || frames[0].sample_idx >= 0,
                  "--rig morphs needs --sample: what the morphs are fitted to");
    const Body& body = inputs.bodies.bodies[frames[0].body_idx];
    std::vector<Pose> poses;
    std::vector<int> pose_indices;
    for (const Selection& frame : frames) {
        require_input(frame.body_idx == frames[0].body_idx, "--rig: frame {} is of body {}, the first of body {}",
                      poses.size(), frame.body_idx, frames[0].body_idx);
        poses.push_back(frame.pose_idx < 0 ? Pose::rest(inputs.poser.body_template().skeleton.num_joints())
                                           : inputs.poses.poses[frame.pose_idx]);
        pose_indices.push_back(frame.pose_idx);
    }
    BodyRig rig = body_rig(inputs.poser, body, poses, options, [&](int frame_idx) {
        return inputs.poser.pose(body, poses[frame_idx])
            .display_skin(inputs.files[0].points(frames[frame_idx].sample_idx));
    });
    rig.rig.mesh_idx = int(skin - sequence.meshes.begin());
    sequence.rig = rig.rig;
    if (frames.size() > 1) sequence.clips = pose_clips(inputs.poses, pose_indices);
    return rig;
}

/// Keeps references to `settings` and `inputs`.
VideoMotion video_motion(const std::vector<Selection>& frames, const SectionChoice& cut,
                         const PictureSettings& settings, const Inputs& inputs)
{
    const Template& body_template = inputs.poser.body_template();
    const Body& body = inputs.bodies.bodies[frames[0].body_idx];
    VideoMotion motion;
    motion.body_template = &body_template;
    motion.num_poses = int(frames.size());
    motion.view = settings.view;
    std::vector<int> pose_indices;
    for (const Selection& frame : frames) pose_indices.push_back(frame.pose_idx);
    if (frames.size() > 1) motion.pose_rate = shown_frame_rate(inputs.poses, pose_indices);
    motion.moment = [frames, cut, &inputs](int frame_idx) {
        const Selection& selection = frames[frame_idx];
        const Pose rest = Pose::rest(inputs.poser.body_template().skeleton.num_joints());
        const PosedBody posed =
            inputs.poser.pose(inputs.bodies.bodies[selection.body_idx],
                              selection.pose_idx < 0 ? rest : inputs.poses.poses[selection.pose_idx]);
        return VideoMoment{geometry_of(selection, inputs), posed_cut(posed, cut)};
    };
    motion.skin = [&body_template, &body, &settings](const VideoMoment& moment) {
        return shown_skin(body_template, body, moment.geometry, settings);
    };
    return motion;
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
    Tool tool("export-scene", "Renders pictures of bodies and samples, and writes them as meshes for other programs",
              "export-scene --template template.h5 --bodies bodies.h5 --body 3 --picture layers.png "
              "--picture-kind layers --mesh body.glb");
    std::string template_path, bodies_path, poses_path, reference_path, mesh_path, page_path, picture_path, video_path,
        report_path;
    std::vector<std::string> deformation_paths;
    Selection asked;
    PosingOptions posing;
    std::string kind = "body", split = "test", colour = "plain", surface = "all";
    int count = 3, num_frames = 1;
    PictureSettings settings;
    ContactSheetSettings sheet;
    SectionChoice section;
    VideoSettings video;
    int height = 0;
    double error_range_mm = 5.0;
    tool.input("template", template_path, "Template");
    tool.input("bodies", bodies_path, "Layered bodies");
    tool.input("poses", poses_path, "Poses, for --pose, --sample, frames and poses", false);
    tool.input("deformations", deformation_paths, "Samples or predictions; several for frames", false);
    tool.input("reference", reference_path, "Samples of the same bodies and poses by which .xdmf has an error", false);
    std::string formats;
    for (const ExportFormat& format : export_formats())
        formats += fmt::format("{}{} ({})", formats.empty() ? "" : ", ", format.extension, format.summary);
    tool.output("mesh", mesh_path, "The body with what lies inside, by extension " + formats, false);
    tool.output("bake-report", report_path, "JSON: how near --rig morphs comes to the samples, mm a frame", false);
    tool.output("page", page_path,
                "HTML page that shows the samples of --deformations in motion, several methods beside each other",
                false);
    tool.output("picture", picture_path, "PNG picture", false);
    tool.output(
        "video", video_path,
        "Poses or samples one after the other, or a camera on its way: animated .webp, .png (numbered, out_{:04}.png), "
        "or .mp4, .mkv, .mov, .webm, .gif by ffmpeg",
        false);
    tool.parameter("body", asked.body_idx, "Body index", 0, 1 << 30);
    tool.parameter("pose", asked.pose_idx, "Pose index, moved by linear blend skinning; -1: at rest", -1, 1 << 30);
    tool.parameter("sample", asked.sample_idx, "Sample of the deformation file; -1: none", -1, 1 << 30);
    tool.parameter("frames", num_frames,
                   "Poses or samples from --pose or --sample on that --mesh, --page or --video holds; where each is a "
                   "file, its name holds "
                   "the place of the number, out_{:04}.ply; 0: all",
                   0, 1000000);
    tool.parameter("surface", surface, "What --mesh holds; parts: all, with each bone and muscle as a mesh of its own",
                   body_mesh_choices);
    tool.parameter("picture-kind", kind, "What the picture shows",
                   {"body", "layers", "cut", "section", "frames", "worst", "errors", "bodies", "poses"});
    tool.parameter("plane", section.kind, "Plane of --picture-kind section and --show cut-away");
    tool.parameter("through", section.joint, "Joint the plane goes through; empty: pelvis, left_upper_arm or spine_4");
    tool.parameter("offset", section.offset, "Metres from there to the left, forward or up", -2.0, 2.0);
    RigOptions rig_options;
    tool.options(rig_options);
    tool.options(posing);
    tool.options(video);
    tool.parameter("view", settings.view, "Where the camera stands");
    tool.parameter("colour", colour, "Skin in plain colour or by volume change", {"plain", "volume"});
    tool.parameter("colour-range", settings.colour_range, "Volume change shown in full colour", 1e-3, 10.0);
    tool.parameter("error-range", error_range_mm, "Distance in mm shown in full red, for --picture-kind errors", 0.01,
                   1000.0);
    tool.parameter("split", split, "Split the frames are taken from", split_names);
    tool.parameter("count", count,
                   "Number of frames, bodies or poses shown (section: 1 for the one of --body, more spread evenly)", 1,
                   2000);
    tool.parameter("height", height, "Pixels of one body; 0: 1200, and 200 on a sheet of poses", 0, 8192);
    tool.parameter("supersampling", settings.samples_per_axis, "Rays along each side of a pixel", 1, 8);

    return tool.run(argc, argv, [&] {
        require_input(!mesh_path.empty() || !page_path.empty() || !picture_path.empty() || !video_path.empty(),
                      "Give --picture, --mesh, --page, --video or several of them");
        require_input(report_path.empty() || rig_options.kind == RigKind::morphs, "--bake-report needs --rig morphs");
        require_input(rig_options.kind == RigKind::none || !mesh_path.empty(), "--rig is for --mesh");
        sheet.view = settings.view;
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
        const int num_page_frames = num_frames;
        if (num_frames == 0) num_frames = remaining_frames(asked, poses, files);
        if (!mesh_path.empty())
            for (const std::string& file : exported_files(mesh_path, num_frames))
                require_input(tool.force() || !std::filesystem::exists(file),
                              "--mesh: {} exists already, give --force to overwrite it", file);
        for (std::size_t i = 0; i < files.size(); ++i) {
            require_input(files[i].posing.bone_wrap == files[0].posing.bone_wrap,
                          "{} and {} are of bodies posed in different ways (bone-wrap)", deformation_paths[0],
                          deformation_paths[i]);
            posing = files[0].posing;
        }
        const BodyPoser poser(body_template, posing);
        const Inputs inputs{poser, bodies, poses, files};
        if (!mesh_path.empty()) {
            std::optional<DeformationSet> reference;
            if (!reference_path.empty()) {
                require_input(asked.sample_idx >= 0, "--reference needs --sample: what is compared with it");
                reference = open_deformations(reference_path, body_template.num_volume_vertices());
            }
            const InputPaths paths{template_path, bodies_path, deformation_paths};
            const std::vector<Selection> frames = select_frames(asked, num_frames, inputs);
            const Contents contents = export_format(mesh_path).contents;
            MeshSequence sequence =
                mesh_sequence(frames, surface, settings, inputs, paths, reference ? &*reference : nullptr, contents);
            BodyRig rig;
            if (rig_options.kind != RigKind::none) {
                require_input(contents == Contents::surfaces_and_rig, "--rig: {} holds no skeleton; .glb and .usda do",
                              mesh_path);
                rig = add_rig(sequence, frames, inputs, rig_options);
            }
            sequence.credits = credits_of(tool.provenance());
            if (sequence.volume) sequence.volume->provenance = tool.provenance();
            export_meshes(mesh_path, sequence);
            if (rig_options.kind == RigKind::morphs) std::cout << bake_table(rig.baked);
            if (!report_path.empty()) write_file(report_path, bake_report(rig, rig_options));
            std::cout << mesh_path << "\n";
        }
        if (!page_path.empty()) {
            PageMotion motion = page_motion(bodies, poses, files, std::max(0, asked.sample_idx), num_page_frames);
            motion.credits = credits_of(tool.provenance());
            const PageFigures figures = write_page(page_path, poser, motion);
            fmt::print(
                "{}: {} frames of {} methods, every vertex within {:.2f} mm; {} of {} anatomy vertices are stored\n",
                page_path, motion.poses.size(), motion.methods.size(), 1e3 * figures.largest_error, figures.num_stored,
                figures.num_anatomy);
        }
        if (!video_path.empty()) {
            video.samples_per_axis = settings.samples_per_axis;
            write_video(video_path,
                        Video(video_motion(select_frames(asked, num_frames, inputs), section, settings, inputs), video),
                        video.quality);
            write_credits_beside(video_path, credits_of(tool.provenance()));
            std::cout << video_path << "\n";
        }
        if (picture_path.empty()) return;
        require_input(kind != "cut" || select(asked, inputs).pose_idx < 0,
                      "--picture-kind cut shows a body at rest; leave out --pose and --sample, or take section");
        if (kind == "body" || kind == "layers" || kind == "cut") {
            const Selection selection = select(asked, inputs);
            const Body& body = bodies.bodies[std::size_t(selection.body_idx)];
            const BodyGeometry geometry = geometry_of(selection, inputs);
            if (kind == "body") write_png(picture_path, body_picture(body_template, body, geometry, settings));
            if (kind == "layers") write_png(picture_path, layers_picture(body_template, geometry, settings));
            if (kind == "cut") write_png(picture_path, sections_picture(body_template, body, settings));
        }
        if (kind == "section" && select(asked, inputs).pose_idx >= 0) {
            const Selection selection = select(asked, inputs);
            const PosedBody posed = poser.pose(bodies.bodies[selection.body_idx], poses.poses[selection.pose_idx]);
            write_png(picture_path, posed_section_picture(posed, geometry_of(selection, inputs), section, settings));
        } else if (kind == "section") {
            const std::vector<int> shown =
                count == 1 ? std::vector<int>{asked.body_idx} : spread_indices(int(bodies.bodies.size()), count);
            write_png(picture_path, section_sheet(body_template, bodies, shown, section, settings));
        }
        if (kind == "frames")
            write_png(picture_path, frames_picture(poser, bodies, poses, files, split, count, settings));
        if (kind == "worst") {
            require_input(files.size() == 2, "The worst samples need two --deformations, a reference and a prediction");
            const auto worst = worst_samples(body_template, files[0], files[1], split, count);
            write_png(picture_path, frames_picture(poser, bodies, poses, files, worst, settings));
        }
        if (kind == "errors")
            write_png(picture_path, errors_picture(body_template, files, split, error_range_mm, settings));
        if (kind == "bodies") write_png(picture_path, bodies_picture(body_template, bodies, count, settings));
        if (kind == "poses") write_png(picture_path, poses_picture(poser, bodies, asked.body_idx, poses, count, sheet));
        add_png_credits(picture_path, credits_of(tool.provenance()));
        std::cout << picture_path << "\n";
    });
}
