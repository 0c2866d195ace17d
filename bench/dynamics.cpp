// SPDX-License-Identifier: Apache-2.0
// What a time step of soft tissue costs, and what a looser tolerance is worth.
#include "report.h"

#include "dynamics/soft_shapes.h"
#include "ndg/body/pose_set.h"
#include "ndg/core/stopwatch.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/dynamics/avatar_body.h"
#include "ndg/dynamics/simulate_dynamics.h"

#include <fmt/format.h>

#include <omp.h>

#include <optional>

using namespace ndg;

namespace {

Points frame_of(const DynamicBlock& block, std::size_t frame)
{
    const std::vector<float>& values = block.vertices[frame];
    return Eigen::Map<const RowMatrixF>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3).cast<double>();
}

struct Run {
    std::vector<Points> frames;
    double seconds = 0, iterations = 0, factorizations = 0, cg_iterations = 0, converged = 1;
    NewtonTimes parts;
};

Run run(DrivenBody& body, const std::vector<Pose>& poses, const DynamicsOptions& options)
{
    MotionSimulation simulation(body, poses, {}, options);
    Run result;
    std::optional<DynamicState> state;
    const double start = thread_seconds();
    for (int b = 0; b < simulation.num_blocks(); ++b) {
        DynamicBlock block = simulation.run(b, state);
        for (std::size_t f = 0; f < block.times.size(); ++f) {
            result.frames.push_back(frame_of(block, f));
            result.iterations += block.statistics["iterations"][f];
            result.factorizations += block.statistics["factorizations"][f];
            result.cg_iterations += block.statistics["cg_iterations"][f];
            result.converged = std::min(result.converged, block.statistics["converged"][f]);
        }
        state = std::move(block.state);
    }
    result.seconds = thread_seconds() - start;
    result.parts = simulation.seconds();
    return result;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-dynamics", "Times steps of soft tissue on one core.",
              "bench_dynamics --avatar out/demo/avatar/body.h5 --poses out/demo/dynamics/motion.h5");
    std::string avatar_path, poses_path, output;
    int rings = 60, segments = 50, num_steps = 48;
    double exact_tolerance = 0;
    DynamicsOptions options;
    TissueOptions tissue;
    tool.input("avatar", avatar_path, "avatar; without it a tube that bends", false);
    tool.input("poses", poses_path, "motion of the avatar; its first clip is taken", false);
    tool.parameter("rings", rings, "rings of the tube", 3, 10000);
    tool.parameter("segments", segments, "segments of the tube", 3, 10000);
    tool.parameter("steps", num_steps, "time steps", 1, 100000);
    tool.parameter("exact-tolerance", exact_tolerance,
                   "relative tolerance of a second run that the first is compared with; 0: none", 0, 1);
    tool.options(options);
    tool.options(tissue);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        set_num_threads(1);
        omp_set_max_active_levels(0);
        std::optional<Template> tube;
        std::optional<Avatar> avatar;
        std::vector<Pose> poses;
        std::optional<SoftBody> soft;
        std::optional<SoftBodyPoser> poser;
        if (avatar_path.empty()) {
            tube = test::tube_template(rings, segments);
            for (int n = 0; n <= num_steps; ++n) poses.push_back(test::tube_pose(1.2 * n / num_steps));
            soft = test::soft_tube(*tube, 15e3, 15e3);
            poser = test::tube_poser(*tube);
        } else {
            avatar = read_avatar(avatar_path);
            require_input(!poses_path.empty(), "--avatar needs --poses");
            poses = sequences_of(read_poses(poses_path), {}, options.step_rate_hertz)[0].poses;
            poses.resize(std::min(poses.size(), static_cast<std::size_t>(num_steps) + 1));
            soft = soft_body_of(*avatar, TissueStiffness());
            poser = poser_of(*avatar);
        }
        SoftTissueBody body(*soft, *poser, tissue, options.density);
        const Run measured = run(body, poses, options);
        const double steps = static_cast<double>(poses.size() - 1);
        bench::Report report("dynamics");
        report.add("vertices", soft->num_vertices());
        report.add("free_vertices", soft->num_vertices() - soft->num_held);
        report.add("tetrahedra", static_cast<double>(soft->tetrahedra.rows()));
        report.add("steps", steps);
        report.add("step_milliseconds", 1e3 * measured.seconds / steps);
        report.add("hessians_milliseconds", 1e3 * measured.parts.assembly / steps);
        report.add("factorization_milliseconds", 1e3 * measured.parts.factorization / steps);
        report.add("substitution_milliseconds", 1e3 * measured.parts.substitution / steps);
        report.add("evaluation_milliseconds", 1e3 * measured.parts.evaluation / steps);
        report.add("iterations", measured.iterations / steps);
        report.add("factorizations", measured.factorizations / steps);
        report.add("cg_iterations", measured.cg_iterations / steps);
        report.add("all_converged", measured.converged);
        if (exact_tolerance > 0) {
            DynamicsOptions exact = options;
            exact.newton.relative_tolerance = exact_tolerance;
            exact.newton.absolute_tolerance_newton = 0;
            SoftTissueBody again(*soft, *poser, tissue, options.density);
            const Run reference = run(again, poses, exact);
            double worst = 0, moved = 0;
            for (std::size_t f = 0; f < reference.frames.size(); ++f) {
                worst = std::max(worst, (measured.frames[f] - reference.frames[f]).rowwise().norm().maxCoeff());
                const auto step = f * static_cast<std::size_t>(options.steps_per_frame());
                const Points skinned = apply_maps(poser->world_from_unposed(poses[step]), soft->rest);
                moved = std::max(moved, (reference.frames[f] - skinned).rowwise().norm().maxCoeff());
            }
            report.add("worst_error_millimetres", 1e3 * worst);
            report.add("dynamics_millimetres", 1e3 * moved);
            report.add("exact_step_milliseconds", 1e3 * reference.seconds / steps);
        }
        report.print();
        if (!output.empty()) report.write(output);
    });
}
