// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/shards.h"
#include "ndg/display/dynamics_display.h"
#include "ndg/display/penetrations.h"
#include "ndg/display/sequence_picture.h"
#include "ndg/dynamics/avatar_body.h"
#include "ndg/dynamics/interacting_body.h"
#include "ndg/dynamics/layered_driven_body.h"
#include "ndg/dynamics/scene_file.h"
#include "ndg/dynamics/simulate_dynamics.h"
#include "ndg/export/export_meshes.h"
#include "ndg/io/licences.h"

#include <algorithm>
#include <optional>

namespace {

using namespace ndg;

/// Of all surfaces in a scene: those that stand in files of their own are hashed nowhere else.
std::string shapes_hash(const Scene& scene)
{
    std::string bytes;
    const auto add = [&bytes](const TriangleMesh& mesh) {
        bytes.append(reinterpret_cast<const char*>(mesh.vertices.data()), sizeof(double) * mesh.vertices.size());
        bytes.append(reinterpret_cast<const char*>(mesh.triangles.data()), sizeof(int) * mesh.triangles.size());
    };
    for (const Obstacle& obstacle : scene.obstacles) add(obstacle.shape);
    for (const GarmentPlan& garment : scene.garments) add(garment.mesh);
    return sha256(bytes);
}

std::string one_line(const std::string& licences)
{
    std::string line;
    for (const char c : licences) line += c == '\n' ? "; " : std::string(1, c);
    return line;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "simulate-dynamics",
        "Moves a body through motions with inertia: its flesh lags, swings and bears loads. Resumable within a motion.",
        "simulate-dynamics --avatar avatar.h5 --poses jump.h5 --output jump-dynamics.h5 --mesh jump.glb");
    std::string avatar_path, template_path, bodies_path, poses_path, scene_path, stiffness_path, output, mesh, page,
        picture, clip, shard_text = "0/1";
    std::string model = "soft-tissue";
    int body_idx = 0, join = 0;
    double min_converged = 0.99, picture_range = 0;
    TissueStiffness stiffness;
    DynamicsOptions options;
    ContactSceneOptions contact;
    TissueOptions tissue;
    SimulationOptions layered;
    SequencePictureOptions pictured;
    tool.input("avatar", avatar_path, "avatar of soft tissue (make-avatar)", false);
    tool.input("template", template_path, "template of a layered body", false);
    tool.input("bodies", bodies_path, "layered bodies; the template's own without it", false);
    tool.input("stiffness-field", stiffness_path,
               "JSON: moduli at the avatar's control points, in place of --young-normal and --young-tangent", false);
    tool.input("poses", poses_path, "motions on our skeleton, each clip one (import-motion)");
    tool.input("scene", scene_path, "JSON: gravity, loads, obstacles, garments", false);
    tool.output("output", output, "vertices over time; a shard i of n goes to <output>.shards/<i>-of-<n>.h5", true,
                true);
    tool.output("mesh", mesh, "the skin in the first motion, by extension: .glb, .usda, ...", false);
    tool.output("page", page, "HTML file that shows the first motion in a browser, beside skinning alone", false);
    tool.output("picture", picture, "PNG file of frames of the first motion", false);
    tool.parameter("model", model, "soft-tissue: an avatar's; layered: muscle, fat and skin of a layered body",
                   std::vector<std::string>{"soft-tissue", "layered"});
    tool.parameter("body", body_idx, "which of --bodies", 0, 1 << 30);
    tool.parameter("clip", clip, "this clip of --poses alone");
    tool.parameter("shard", shard_text, "i/n: only every n-th motion from i on");
    tool.parameter("join", join, "simulate nothing: put the results of so many shards together as --output", 0, 100000);
    tool.parameter("young-normal", stiffness.young_normal_pascal[0],
                   "Young's modulus of the soft tissue along the skin's normal, Pa", 1.0, 1e9);
    tool.parameter("young-tangent", stiffness.young_tangent_pascal[0], "and along the skin, Pa", 1.0, 1e9);
    tool.options(tissue);
    tool.options(options);
    tool.options(contact);
    tool.options(layered.posing);
    tool.options(layered.material);
    tool.options(pictured);
    tool.parameter("picture-range", picture_range,
                   "distance from the skinned shape in mm that the picture shows in full red; 0: plain skin", 0, 1000);
    tool.parameter("min-converged", min_converged, "smallest share of converged frames for exit code 0", 0, 1);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        options.steps_per_frame();
        const bool soft = model == "soft-tissue";
        const Shard shard = parse_shard(shard_text);
        require_input(avatar_path.empty() != soft && (template_path.empty() && bodies_path.empty()) == soft,
                      "--model {} needs {} alone", model, soft ? "--avatar" : "--template and perhaps --bodies");
        require_input(picture_range == 0 || soft, "--picture-range needs an avatar, which tells the skinned shape");
        const PoseSet poses = read_poses(poses_path);
        const Scene scene = scene_path.empty() ? Scene() : read_scene(scene_path);
        DynamicsRun run;
        run.model = model;
        run.options = options;
        run.loads = scene.loads;
        std::optional<Avatar> avatar;
        std::optional<Template> body_template;
        std::optional<Body> body;
        OptionList list;
        describe(list, options);
        describe(list, contact);
        if (soft) {
            avatar = read_avatar(avatar_path);
            if (!stiffness_path.empty()) read_stiffness(stiffness_path, *avatar, stiffness);
            run.make_actor = [&] {
                DynamicActor actor;
                actor.body =
                    InteractingBody::among(std::make_unique<SoftTissueBody>(soft_body_of(*avatar, stiffness),
                                                                            poser_of(*avatar), tissue, options.density),
                                           scene, contact, actor.hook);
                return actor;
            };
            describe(list, tissue);
            run.options_key = fmt::format("{} {} {}", options_key(list), fmt::join(stiffness.young_normal_pascal, ","),
                                          fmt::join(stiffness.young_tangent_pascal, ","));
        } else {
            body_template = read_template(template_path);
            if (bodies_path.empty()) {
                body = body_template->rest;
            } else {
                const BodySet bodies = read_bodies(bodies_path, *body_template);
                const auto count = static_cast<int>(bodies.bodies.size());
                require_input(body_idx < count, "--body {} of {} bodies", body_idx, count);
                body = bodies.bodies[static_cast<std::size_t>(body_idx)];
            }
            run.make_actor = [&] {
                DynamicActor actor;
                actor.body = InteractingBody::among(
                    std::make_unique<LayeredDrivenBody>(*body_template, *body, layered, options.density), scene,
                    contact, actor.hook);
                return actor;
            };
            describe(list, layered.posing);
            describe(list, layered.material);
            run.options_key = fmt::format("{} {}", options_key(list), body_idx);
        }

        if (!scene_path.empty()) run.options_key += " " + shapes_hash(scene);
        std::vector<std::string> names;
        if (!clip.empty()) names.push_back(clip);
        const std::vector<DynamicSequence> sequences =
            shard_of(sequences_of(poses, names, options.step_rate_hertz), shard);
        const std::string path = shard_path(output, shard);
        const Provenance provenance = tool.provenance();
        const DynamicsSet set =
            join > 0 ? join_dynamics(output, join, provenance)
                     : simulate_dynamics(run, sequences, path, provenance, interrupt_requested, tool.force());
        fmt::print("{}: {}", path, dynamics_report(set));
        const DynamicsReader reader(path);
        const DynamicsDisplay display(reader, soft ? &*avatar : nullptr);
        const std::string credits = one_line(merged_licences(provenance));
        std::vector<PenetrationCount> penetrations;
        if (contact.contact || scene.contact || !set.others.empty()) {
            for (std::size_t i = 0; i < set.sequence_names.size(); ++i) {
                const std::vector<PenetrationCount> counts = count_penetrations(display, static_cast<int>(i));
                fmt::print("\"{}\", what is inside of what:\n{}", set.sequence_names[i], penetration_lines(counts));
                penetrations.insert(penetrations.end(), counts.begin(), counts.end());
            }
        }
        if (!mesh.empty()) {
            const MeshSequence sequence = display.sequence(0, credits);
            export_meshes(mesh, sequence);
            fmt::print("{}: {} frames of \"{}\"\n", mesh, sequence.num_frames, set.sequence_names[0]);
        }
        if (!page.empty()) {
            const double error = write_dynamics_page(page, display, 0, credits);
            fmt::print("{}: every vertex within {:.2f} mm\n", page, 1e3 * error);
        }
        if (!picture.empty())
            write_png(picture, sequence_picture(display.sequence(0, credits, 1e-3 * picture_range), pictured));
        require_apart(penetrations);
        require_converged(set, min_converged);
    });
}
