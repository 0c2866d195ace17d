// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/twin_capture.h"
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/deform/posed_body.h"
#include "ndg/dynamics/layered_driven_body.h"
#include "ndg/dynamics/simulate_dynamics.h"

#include <fmt/format.h>

#include <algorithm>

namespace {

using namespace ndg;

/// Frames of a simulated motion as skins, with the poses that drove them.
CaptureSequence true_sequence(const DynamicsReader& reader, int which, const DynamicSequence& motion,
                              const BodyPoser& poser, const Body& body, int steps_per_frame)
{
    const auto [begin, end] = reader.set().frames_of(which);
    CaptureSequence sequence;
    sequence.name = motion.name;
    sequence.frame_rate_hertz = reader.set().frame_rate_hertz;
    for (int frame = begin; frame < end; ++frame) {
        const int number = frame - begin, last = static_cast<int>(motion.poses.size()) - 1;
        const Pose& pose = motion.poses[static_cast<std::size_t>(std::min(number * steps_per_frame, last))];
        sequence.frame_numbers.push_back(number);
        sequence.poses.push_back(pose);
        sequence.vertices.push_back(poser.pose(body, pose).display_skin(reader.frame(frame)));
    }
    return sequence;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "simulate-capture",
        "Makes a twin of a captured person: a layered body in motion with inertia, of stiffness that is not the "
        "same everywhere, seen with noise and errors of pose. Resumable.",
        "simulate-capture --template template.h5 --bodies bodies.h5 --body 3 --poses motions.h5 --output twin.h5");
    std::string template_path, bodies_path, poses_path, output_path;
    int body_idx = 0;
    TwinOptions twin;
    DynamicsOptions dynamics;
    dynamics.step_rate_hertz = 240;  // half the time step of what is estimated
    SimulationOptions layered;
    layered.material.young_fat_pascal = 6e3;
    layered.material.young_muscle_pascal = 18e3;
    tool.input("template", template_path, "template of the body");
    tool.input("bodies", bodies_path, "layered bodies; the template's own without it", false);
    tool.input("poses", poses_path, "motions, each clip one (import-motion --frame-rate 240 --interpolate)");
    tool.output("output", output_path, "capture to write; the motion without noise goes to <output>.motion.h5", true,
                true);
    tool.parameter("body", body_idx, "which of --bodies", 0, 1 << 30);
    tool.options(twin);
    tool.parameter("step-rate", dynamics.step_rate_hertz, "time steps a second", 1.0, 1e5);
    tool.parameter("density", dynamics.density, "density of the flesh, kg/m^3", 1.0, 1e5);
    tool.options(layered.posing);
    tool.options(layered.material);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        dynamics.frame_rate_hertz = twin.frame_rate_hertz;
        const int steps_per_frame = dynamics.steps_per_frame();
        const Template body_template = read_template(template_path);
        Body body = body_template.rest;
        if (!bodies_path.empty()) {
            const BodySet bodies = read_bodies(bodies_path, body_template);
            const auto count = static_cast<int>(bodies.bodies.size());
            require_input(body_idx < count, "--body {} of {} bodies", body_idx, count);
            body = bodies.bodies[static_cast<std::size_t>(body_idx)];
        }
        const Eigen::VectorXd stiffness = hidden_stiffness(body_template, body, twin, tool.seed());
        const Eigen::VectorXd prisms = prism_stiffness(body_template, stiffness);
        const PoseSet poses = read_poses(poses_path);
        const std::vector<DynamicSequence> motions = sequences_of(poses, {}, dynamics.step_rate_hertz);
        DynamicsRun run;
        run.model = "layered";
        run.options = dynamics;
        run.make_actor = [&] {
            DynamicActor actor;
            actor.body = std::make_unique<LayeredDrivenBody>(body_template, body, layered, dynamics.density, prisms);
            return actor;
        };
        OptionList list;
        describe(list, dynamics);
        describe(list, layered.posing);
        describe(list, layered.material);
        run.options_key = fmt::format("twin {} {} {} {} {}", options_key(list), body_idx, tool.seed(),
                                      twin.heterogeneity, twin.heterogeneity_metre);
        const std::string motion_path = output_path + ".motion.h5";
        const DynamicsSet set =
            simulate_dynamics(run, motions, motion_path, tool.provenance(), interrupt_requested, tool.force());
        fmt::print("{}: {}", motion_path, dynamics_report(set));

        const DynamicsReader reader(motion_path);
        const BodyPoser poser(body_template, layered.posing);
        Capture capture;
        capture.subject = body.name;
        capture.triangles = body_template.skin_triangles;
        capture.joint_names = body_template.skeleton.joint_names;
        capture.true_stiffness.assign(static_cast<std::size_t>(body.skin_vertices.rows()), 0.0);
        for (int w = 0; w < body_template.num_wrap_vertices(); ++w) {
            capture.true_stiffness[static_cast<std::size_t>(body_template.wrap_to_skin[static_cast<std::size_t>(w)])] =
                stiffness[w];
        }
        for (const DynamicSequence& motion : motions) {
            const auto found = std::find(set.sequence_names.begin(), set.sequence_names.end(), motion.name);
            require(found != set.sequence_names.end(), "motion \"{}\" did not come through", motion.name);
            const auto which = static_cast<int>(found - set.sequence_names.begin());
            capture.sequences.push_back(observed(true_sequence(reader, which, motion, poser, body, steps_per_frame),
                                                 twin, tool.seed(), motion.index));
        }
        write_capture(output_path, capture, tool.provenance());
        fmt::print("{}: {} sequences at {:g} Hz, noise {:g} mm\n", output_path, capture.sequences.size(),
                   twin.frame_rate_hertz, twin.noise_millimetre);
        require_converged(set, 0.99);
    });
}
