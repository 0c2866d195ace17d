// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/export/export_meshes.h"
#include "ndg/page/page.h"
#include "ndg/scene/colour_map.h"
#include "ndg/scene/contact_sheet.h"
#include "ndg/scene/error_pictures.h"
#include "ndg/scene/pictures.h"
#include "ndg/scene/video.h"
#include "ndg/scene/video_file.h"

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

/// The pose or sample `frame_idx` places after the one that is asked for.
Selection selected_frame(const Selection& asked, int frame_idx, const Inputs& inputs)
{
    require_input(frame_idx == 0 || asked.pose_idx >= 0 || asked.sample_idx >= 0,
                  "--frames {} needs --pose or --sample to start from", frame_idx + 1);
    Selection selection = asked;
    if (frame_idx > 0) (asked.sample_idx >= 0 ? selection.sample_idx : selection.pose_idx) += frame_idx;
    return select(selection, inputs);
}

BodyGeometry geometry_of(const Selection& selection, const Inputs& inputs)
{
    const Body& body = inputs.bodies.bodies[selection.body_idx];
    if (selection.pose_idx < 0) return rest_geometry(inputs.poser.body_template(), body);
    const PosedBody posed = inputs.poser.pose(body, inputs.poses.poses[selection.pose_idx]);
    if (selection.sample_idx < 0) return skinned_geometry(posed);
    return posed_geometry(posed, inputs.files[0].points(selection.sample_idx));
}

/// Bones or muscles, gathered in one surface, as the parts they were gathered from.
std::vector<SceneSurface> split_into_parts(const SceneSurface& gathered, AnatomyLayer layer,
                                           const std::vector<AnatomyPart>& parts)
{
    std::vector<SceneSurface> surfaces;
    Eigen::Index vertex = 0, triangle = 0;
    for (const AnatomyPart& part : parts) {
        if (part.layer != layer) continue;
        const Eigen::Index num_vertices = part.vertex_end - part.vertex_begin;
        const Eigen::Index num_triangles = part.triangle_end - part.triangle_begin;
        SceneSurface& surface = surfaces.emplace_back(gathered);
        surface.name = part.name;
        surface.vertices = gathered.vertices.middleRows(vertex, num_vertices);
        surface.triangles = gathered.triangles.middleRows(triangle, num_triangles).array() - int(vertex);
        vertex += num_vertices;
        triangle += num_triangles;
    }
    return surfaces;
}

/// The surfaces of a body that are exported: all, or the one called `surface`; "parts": all, each bone and muscle one.
std::vector<SceneSurface> exported_surfaces(const Template& body_template, const BodyGeometry& geometry,
                                            const std::string& surface)
{
    std::vector<SceneSurface> surfaces;
    for (SceneSurface& gathered : anatomy_surfaces(body_template, geometry)) {
        const AnatomyLayer layer = gathered.name == "bones" ? AnatomyLayer::bone : AnatomyLayer::muscle;
        if (surface != "parts")
            surfaces.push_back(std::move(gathered));
        else
            for (SceneSurface& part : split_into_parts(gathered, layer, body_template.anatomy_parts))
                surfaces.push_back(std::move(part));
    }
    surfaces.push_back(bone_wrap_surface(body_template, geometry));
    surfaces.push_back(muscle_wrap_surface(body_template, geometry));
    surfaces.push_back(skin_surface(body_template, geometry));
    if (surface == "all" || surface == "parts") {
        // So that what lies inside shows through.
        surfaces.back().opacity = 0.35f;
        surfaces[surfaces.size() - 2].opacity = 0.5f;
        return surfaces;
    }
    const auto found = std::find_if(surfaces.begin(), surfaces.end(),
                                    [&](const SceneSurface& candidate) { return candidate.name == surface; });
    require_input(found != surfaces.end(), "--surface {}: the template has none", surface);
    return {*found};
}

std::string credits_of(const Provenance& provenance)
{
    std::string credits;
    for (const Provenance::Input& file : provenance.inputs)
        if (!file.licences.empty() && credits.find(file.licences) == std::string::npos)
            credits += (credits.empty() ? "" : "; ") + file.licences;
    return credits;
}

/// Change of volume below each vertex of the skin, N_s; 0 for head, hands and toes.
Eigen::VectorXf skin_volume_change(const Template& body_template, const Body& body, const BodyGeometry& geometry)
{
    const Eigen::VectorXd change = volume_change(body.volume_vertices, geometry.volume_vertices, body_template.prisms,
                                                 body_template.num_wrap_vertices());
    Eigen::VectorXf values = Eigen::VectorXf::Zero(geometry.skin_vertices.rows());
    for (int w = 0; w < change.size(); ++w) values[body_template.wrap_to_skin[w]] = float(change[w]);
    return values;
}

/// How many samples of the file, or poses, there are from `asked` on; 1 for a body at rest.
int remaining_frames(const Selection& asked, const PoseSet& poses, const std::vector<DeformationSet>& files)
{
    if (asked.sample_idx >= 0) return std::max(1, (files.size() == 1 ? files[0].size() : 0) - asked.sample_idx);
    return asked.pose_idx < 0 ? 1 : std::max(1, poses.size() - asked.pose_idx);
}

/// `num_frames` poses or samples from `asked` on. Keeps references to `settings` and `inputs`.
MeshSequence mesh_sequence(const Selection& asked, int num_frames, const std::string& surface,
                           const PictureSettings& settings, const Inputs& inputs)
{
    const auto selected = [asked, &inputs](int frame_idx) { return selected_frame(asked, frame_idx, inputs); };
    selected(num_frames - 1);  // out of range is found before anything is written
    const Template& body_template = inputs.poser.body_template();
    const Selection first = selected(0);
    MeshSequence sequence;
    for (const SceneSurface& candidate : exported_surfaces(body_template, geometry_of(first, inputs), surface))
        sequence.meshes.push_back({candidate.name, candidate.triangles, candidate.colour, candidate.opacity,
                                   candidate.gloss, candidate.two_sided});
    if (surface == "parts")
        for (ExportedMesh& mesh : sequence.meshes)
            for (const AnatomyPart& part : body_template.anatomy_parts)
                if (part.name == mesh.name) {
                    mesh.group = part.layer == AnatomyLayer::bone ? "bones" : "muscles";
                    mesh.fma_id = part.fma_id;
                }
    sequence.num_frames = num_frames;
    if (first.pose_idx >= 0) sequence.frame_rate = inputs.poses.clip_frame_rates[inputs.poses.clip_idx[first.pose_idx]];
    sequence.frame = [selected, surface, &settings, &inputs, &body_template](int frame_idx) {
        const Selection selection = selected(frame_idx);
        const Body& body = inputs.bodies.bodies[selection.body_idx];
        const BodyGeometry geometry = geometry_of(selection, inputs);
        std::vector<MeshFrame> frames;
        for (const SceneSurface& candidate : exported_surfaces(body_template, geometry, surface)) {
            MeshFrame& frame = frames.emplace_back();
            frame.vertices = candidate.vertices;
            if (!settings.volume_colours || candidate.name != "skin") continue;
            frame.colours = volume_change_surface(body_template, body, geometry, settings.colour_range).vertex_colours;
            frame.scalars["volume_change"] = skin_volume_change(body_template, body, geometry);
        }
        return frames;
    };
    return sequence;
}

/// Of poses in their order, Hz: that of their clip, thinned as they are; of poses that are no motion, slow.
double shown_frame_rate(const std::vector<int>& shown, const PoseSet& poses)
{
    constexpr double no_motion = 1.5;
    if (shown.size() < 2) return no_motion;
    const int clip_idx = poses.clip_idx[shown[0]];
    const int step = poses.frame_idx[shown[1]] - poses.frame_idx[shown[0]];
    for (std::size_t k = 1; k < shown.size(); ++k)
        if (poses.clip_idx[shown[k]] != clip_idx || poses.frame_idx[shown[k]] - poses.frame_idx[shown[k - 1]] != step ||
            step <= 0)
            return no_motion;
    return poses.clip_frame_rates[clip_idx] / step;
}

/// The frames of a page: the samples of the first deformation file from `asked` on that are of its body, in their
/// order, with what each of the other files makes of them. Keeps references to `inputs`.
PageMotion page_motion(const Selection& asked, int num_frames, const Inputs& inputs)
{
    require_input(!inputs.files.empty(), "--page needs --deformations: the samples to show, of one method or several");
    const DeformationSet& reference = inputs.files[0];
    const int first = std::max(0, asked.sample_idx);
    require_input(first < reference.size(), "--sample {} lies outside the {} samples of the {} file", first,
                  reference.size(), reference.method);
    const int body_idx = reference.pairs[first].body_idx;
    std::vector<std::vector<int>> samples(inputs.files.size());  // file, frame
    std::vector<int> shown;
    PageMotion motion;
    for (int s = first; s < reference.size() && (num_frames == 0 || int(motion.poses.size()) < num_frames); ++s) {
        const SamplePair& pair = reference.pairs[s];
        if (pair.body_idx != body_idx) continue;
        require_pair(pair, inputs.bodies.bodies.size(), inputs.poses.poses.size());
        for (std::size_t f = 0; f < inputs.files.size(); ++f) {
            const std::vector<SamplePair>& pairs = inputs.files[f].pairs;
            const auto found = std::find(pairs.begin(), pairs.end(), pair);
            require_input(found != pairs.end(), "the {} file has no sample of {}", inputs.files[f].method,
                          describe(pair));
            samples[f].push_back(int(found - pairs.begin()));
        }
        shown.push_back(pair.pose_idx);
        motion.poses.push_back(inputs.poses.poses[pair.pose_idx]);
    }
    const int pose_idx = reference.pairs[first].pose_idx, clip_idx = inputs.poses.clip_idx[pose_idx];
    motion.body = &inputs.bodies.bodies[body_idx];
    motion.frame_rate = shown_frame_rate(shown, inputs.poses);
    motion.title = fmt::format("{}, {}", motion.body->name, inputs.poses.clip_names[clip_idx]);
    for (std::size_t f = 0; f < inputs.files.size(); ++f)
        motion.methods.push_back({inputs.files[f].method, [&file = inputs.files[f], chosen = samples[f]](int frame) {
                                      return file.points(chosen[frame]);
                                  }});
    return motion;
}

/// `num_poses` poses or samples from `asked` on. Keeps references to `settings` and `inputs`.
VideoMotion video_motion(const Selection& asked, int num_poses, const SectionChoice& cut,
                         const PictureSettings& settings, const Inputs& inputs)
{
    const Selection first = select(asked, inputs);
    const Template& body_template = inputs.poser.body_template();
    const Body& body = inputs.bodies.bodies[first.body_idx];
    VideoMotion motion;
    motion.body_template = &body_template;
    motion.num_poses = num_poses;
    motion.view = settings.view;
    if (num_poses > 1) {
        std::vector<int> shown;
        for (int k = 0; k < num_poses; ++k) shown.push_back(selected_frame(asked, k, inputs).pose_idx);
        motion.pose_rate = shown_frame_rate(shown, inputs.poses);
    }
    motion.moment = [asked, cut, &inputs](int frame_idx) {
        const Selection selection = selected_frame(asked, frame_idx, inputs);
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
    std::string template_path, bodies_path, poses_path, mesh_path, page_path, picture_path, video_path;
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
    std::string formats;
    for (const ExportFormat& format : export_formats())
        formats += fmt::format("{}{} ({})", formats.empty() ? "" : ", ", format.extension, format.summary);
    tool.output("mesh", mesh_path, "The body with what lies inside, by extension " + formats, false);
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
                   {"all", "parts", "skin", "muscle_wrap", "bone_wrap", "bones", "muscles"});
    tool.parameter("picture-kind", kind, "What the picture shows",
                   {"body", "layers", "cut", "section", "frames", "worst", "errors", "bodies", "poses"});
    tool.parameter("plane", section.kind, "Plane of --picture-kind section and --show cut-away");
    tool.parameter("through", section.joint, "Joint the plane goes through; empty: pelvis, left_upper_arm or spine_4");
    tool.parameter("offset", section.offset, "Metres from there to the left, forward or up", -2.0, 2.0);
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
            MeshSequence sequence = mesh_sequence(asked, num_frames, surface, settings, inputs);
            sequence.credits = credits_of(tool.provenance());
            export_meshes(mesh_path, sequence);
            std::cout << mesh_path << "\n";
        }
        if (!page_path.empty()) {
            PageMotion motion = page_motion(asked, num_page_frames, inputs);
            motion.credits = credits_of(tool.provenance());
            const PageFigures figures = write_page(page_path, poser, motion);
            fmt::print(
                "{}: {} frames of {} methods, every vertex within {:.2f} mm; {} of {} anatomy vertices are stored\n",
                page_path, motion.poses.size(), motion.methods.size(), 1e3 * figures.largest_error, figures.num_stored,
                figures.num_anatomy);
        }
        if (!video_path.empty()) {
            video.samples_per_axis = settings.samples_per_axis;
            write_video(video_path, Video(video_motion(asked, num_frames, section, settings, inputs), video),
                        video.quality);
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
        std::cout << picture_path << "\n";
    });
}
