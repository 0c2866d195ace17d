// SPDX-License-Identifier: Apache-2.0
// Core-seconds of one FEM sample, and where they go. Without --template: a bent tube.
#include "ndg/body/joint_flesh.h"
#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/motion/clinical_angles.h"
#include "ndg/simulation/simulator.h"
#include "ndg/solver/sparse_cholesky.h"
#include "report.h"
#include "support/support.h"

#include "ndg/body/pose_set.h"

#include <omp.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include <numeric>

using namespace ndg;

namespace {

double seconds_of(const std::function<void()>& work)
{
    const double start = thread_seconds();
    work();
    return thread_seconds() - start;
}

struct NamedPose {
    std::string name;
    Pose pose;
};

struct Case {
    Template body_template;
    std::vector<Body> bodies;
    std::vector<NamedPose> poses;
};

/// The poses that bend furthest in some way, then others spread evenly over the set; prints their clinical angles.
std::vector<NamedPose> pick_poses(const PoseSet& poses, const Points& joint_positions, int count)
{
    const ClinicalFrames frames(joint_positions);
    std::vector<std::vector<double>> angles;
    for (const Pose& pose : poses.poses) angles.push_back(frames.angles(pose));
    const auto angle = [&](int pose, const std::string& name) { return angles[pose][find_clinical_angle(name)]; };
    const auto both = [&](int pose, const std::string& name) {
        return std::min(angle(pose, "left_" + name), angle(pose, "right_" + name));
    };
    const std::vector<std::pair<std::string, std::function<double(int)>>> kinds{
        {"deep knee bend", [&](int p) { return both(p, "knee.flexion"); }},
        {"arms overhead", [&](int p) { return both(p, "shoulder.elevation"); }},
        {"bent trunk", [&](int p) { return angle(p, "trunk.flexion"); }},
        {"twisted trunk", [&](int p) { return std::abs(angle(p, "trunk.turn_left")); }},
        {"bent hips", [&](int p) { return both(p, "hip.flexion"); }},
        {"bent elbows", [&](int p) { return both(p, "elbow.flexion"); }},
        {"high knee",
         [&](int p) {
             return std::max(std::min(angle(p, "left_hip.flexion"), angle(p, "left_knee.flexion")),
                             std::min(angle(p, "right_hip.flexion"), angle(p, "right_knee.flexion")));
         }},
        {"arms forward",
         [&](int p) {  // elevated by 90 degrees in the sagittal plane
             constexpr double quarter = 1.5707963267948966;
             const auto off = [&](const std::string& side) {
                 return std::abs(angle(p, side + "_shoulder.elevation") - quarter) +
                        std::abs(angle(p, side + "_shoulder.plane") - quarter);
             };
             return -std::max(off("left"), off("right"));
         }},
        {"legs apart", [&](int p) { return both(p, "hip.abduction"); }},
        {"trunk bent sideways", [&](int p) { return std::abs(angle(p, "trunk.bend_left")); }},
    };
    std::vector<std::pair<std::string, int>> chosen;
    const auto is_chosen = [&](int pose) {
        return std::any_of(chosen.begin(), chosen.end(), [&](const auto& pick) { return pick.second == pose; });
    };
    for (const auto& [name, measure] : kinds) {
        int best = -1;
        for (int p = 0; p < poses.size(); ++p) {
            if (!is_chosen(p) && (best < 0 || measure(p) > measure(best))) best = p;
        }
        if (best >= 0 && static_cast<int>(chosen.size()) < count) chosen.emplace_back(name, best);
    }
    for (int k = 0; k < poses.size() && static_cast<int>(chosen.size()) < count; ++k) {
        const int p = static_cast<int>((static_cast<long>(k) * 37) % poses.size());
        if (!is_chosen(p)) chosen.emplace_back("other", p);
    }
    fmt::print(
        "pose                 of the set  clip                        knees     shoulders  trunk       hips      "
        "elbows\n");
    std::vector<NamedPose> result;
    constexpr double degree = 57.29577951308232;
    for (const auto& [name, p] : chosen) {
        const auto pair = [&, pose = p](const std::string& joint) {
            return fmt::format("{:.0f} {:.0f}", degree * angle(pose, "left_" + joint),
                               degree * angle(pose, "right_" + joint));
        };
        fmt::print(
            "{:<20} {:>10}  {:<26}  {:<8}  {:<9}  {:<10}  {:<8}  {}\n", name, p, poses.clip_names[poses.clip_idx[p]],
            pair("knee.flexion"), pair("shoulder.elevation"),
            fmt::format("{:.0f} {:+.0f}", degree * angle(p, "trunk.flexion"), degree * angle(p, "trunk.turn_left")),
            pair("hip.flexion"), pair("elbow.flexion"));
        result.push_back({name, poses.poses[p]});
    }
    return result;
}

Case read_case(const std::string& template_path, const std::string& bodies_path, const std::string& poses_path,
               int num_bodies, int num_poses, int rings)
{
    Case result;
    if (template_path.empty()) {
        result.body_template = test::tube_template(rings, 16);
        result.bodies = {result.body_template.rest};
        for (int i = 0; i < num_poses; ++i) {
            const double angle = 0.3 + 1.5 * i / num_poses;
            result.poses.push_back({fmt::format("bent by {:.2f}", angle), test::tube_pose(angle)});
        }
        return result;
    }
    result.body_template = read_template(template_path);
    result.bodies = {result.body_template.rest};
    if (!bodies_path.empty()) {
        const std::vector<Body> all = read_bodies(bodies_path, result.body_template).bodies;
        const auto available = static_cast<long>(all.size());
        const long used = std::min<long>(num_bodies, available);
        result.bodies.clear();
        for (long b = 0; b < used; ++b) result.bodies.push_back(all[b * available / used]);
    }
    require_input(!poses_path.empty(), "--poses must be given with --template");
    result.poses = pick_poses(read_poses(poses_path), result.body_template.rest.joint_positions, num_poses);
    return result;
}

double peak_memory_mib()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-fem", "Times FEM samples on one core: every body in every pose.",
              "bench_fem --template out/paper/template.h5 --bodies out/paper/bodies.h5 --poses out/paper/poses.h5");
    std::string template_path, bodies_path, poses_path, output;
    int num_bodies = 3, num_poses = 10, rings = 100, num_plain = 0;
    SimulationOptions options;
    tool.input("template", template_path, "template; without it the built-in tube, bent by linear blend skinning",
               false);
    tool.input("bodies", bodies_path, "bodies; the template's own without it", false);
    tool.input("poses", poses_path, "poses, of which those that bend furthest are taken first", false);
    tool.parameter("body-count", num_bodies, "bodies, spread over those given", 1, 100000);
    tool.parameter("pose-count", num_poses, "poses", 1, 100000);
    tool.parameter("plain", num_plain, "so many samples also without relaxed creases, for comparison", 0, 100000);
    tool.parameter("rings", rings, "rings of the tube", 3, 100000);
    tool.options(options);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        set_num_threads(1);
        omp_set_max_active_levels(0);  // CHOLMOD's own parallel sections too
        const Case bench = read_case(template_path, bodies_path, poses_path, num_bodies, num_poses, rings);
        if (template_path.empty()) options.posing = test::bending;
        Simulator simulator(bench.body_template, options);
        std::vector<double> seconds, iterations, factorizations;
        NewtonTimes times;
        int converged = 0, stepped = 0, without_inverted = 0, without_corner_inverted = 0;
        double inverted = 0, corner_inverted = 0, intersecting = 0, intersecting_bones = 0, body_seconds = 0,
               plain_seconds = 0, same_seconds = 0;
        int plain_converged = 0, plain_done = 0;
        std::vector<std::vector<double>> volume_changes(flesh_joint_names().size());
        Points last;
        for (std::size_t b = 0; b < bench.bodies.size(); ++b) {
            const double start = thread_seconds();
            simulator.set_body(bench.bodies[b]);
            const double of_body = thread_seconds() - start;
            body_seconds += of_body;
            for (const NamedPose& pose : bench.poses) {
                SimulationResult result;
                // A body's own share is spread over its poses, as in a dataset that goes through the bodies in turn.
                seconds.push_back(seconds_of([&] { result = simulator.simulate(pose.pose); }) +
                                  of_body / static_cast<double>(bench.poses.size()));
                const NewtonResult& newton = result.newton;
                iterations.push_back(newton.iterations);
                factorizations.push_back(newton.factorizations);
                converged += newton.converged();
                stepped += result.load_steps > 0;
                inverted += result.inverted_prisms.by_volume;
                corner_inverted += result.inverted_prisms.at_corners;
                intersecting += result.intersecting_triangles;
                const Triangles& wrap = bench.body_template.wrap_triangles;
                const std::size_t crossing_bones =
                    triangles_of_pairs(
                        crossing_triangles(result.vertices.topRows(bench.body_template.num_wrap_vertices()), wrap))
                        .size();
                intersecting_bones += static_cast<double>(crossing_bones);
                for (std::size_t joint = 0; joint < volume_changes.size(); ++joint)
                    volume_changes[joint].push_back(result.volume_changes[joint]);
                without_inverted += result.inverted_prisms.by_volume == 0;
                without_corner_inverted += result.inverted_prisms.at_corners == 0;
                times.relaxation += newton.seconds.relaxation;
                times.assembly += newton.seconds.assembly;
                times.factorization += newton.seconds.factorization;
                times.substitution += newton.seconds.substitution;
                times.evaluation += newton.seconds.evaluation;
                last = result.vertices;
                fmt::print(
                    stderr,
                    "body {} {:<20} {:5.2f} s: {:2d} iterations, {:2d} factorizations, {:2d} CG; {}, {:.1e} N, "
                    "relative {:.1e}; {} inverted, {} at corners; {} skin triangles intersect, {} of the bone wrap\n",
                    b, pose.name, seconds.back(), newton.iterations, newton.factorizations, newton.cg_iterations,
                    describe(newton.stop), newton.residual_newton, newton.residual_relative,
                    result.inverted_prisms.by_volume, result.inverted_prisms.at_corners, result.intersecting_triangles,
                    crossing_bones);
                if (plain_done >= num_plain) continue;
                ++plain_done;
                same_seconds += seconds.back();
                NewtonSolver plain(simulator.objective());
                Points positions = simulator.start(pose.pose);
                plain_seconds +=
                    seconds_of([&] { plain_converged += plain.minimise(positions, options.newton).converged(); });
            }
        }
        const double samples = static_cast<double>(seconds.size());
        const double total = std::accumulate(seconds.begin(), seconds.end(), 0.0);
        const double rest =
            total - times.relaxation - times.assembly - times.factorization - times.substitution - times.evaluation;
        fmt::print("\nwhere the time goes, core-seconds a sample\n");
        for (const auto& [name, value] :
             std::vector<std::pair<const char*, double>>{{"creases relaxed by themselves", times.relaxation},
                                                         {"Hessians", times.assembly},
                                                         {"factorisation", times.factorization},
                                                         {"substitution, conjugate gradients", times.substitution},
                                                         {"energies, gradients, line search", times.evaluation},
                                                         {"start, rest data of the body", rest}}) {
            fmt::print("{:<36} {:6.3f}  {:4.1f} %\n", name, value / samples, 100 * value / total);
        }
        fmt::print("\n");

        const Objective& objective = simulator.objective();
        Eigen::SparseMatrix<double> hessian = objective.hessian_pattern();
        SingleCholesky single;
        SparseCholesky cholesky(SparseCholesky::Method::supernodal);
        single.analyze(hessian);
        cholesky.analyze(hessian);
        Eigen::VectorXd gradient, absolute, solution;
        bench::Report report("fem");
        report.add("prisms", static_cast<double>(bench.body_template.num_prisms()));
        report.add("unknowns", objective.num_unknowns());
        report.add("samples", samples);
        report.add("core_seconds_median", bench::quantile(seconds, 0.5));
        report.add("core_seconds_p95", bench::quantile(seconds, 0.95));
        report.add("core_seconds_mean", total / samples);
        report.add("core_seconds_max", bench::quantile(seconds, 1));
        report.add("iterations_median", bench::quantile(iterations, 0.5));
        report.add("iterations_max", bench::quantile(iterations, 1.0));
        report.add("factorizations_median", bench::quantile(factorizations, 0.5));
        report.add("converged_share", converged / samples);
        report.add("load_stepped_share", stepped / samples);
        report.add("inverted_prisms_mean", inverted / samples);
        report.add("frames_without_inverted", without_inverted / samples);
        report.add("corner_inverted_prisms_mean", corner_inverted / samples);
        report.add("frames_without_corner_inverted", without_corner_inverted / samples);
        report.add("intersecting_skin_triangles_mean", intersecting / samples);
        report.add("intersecting_bone_wrap_triangles_mean", intersecting_bones / samples);
        report.add("peak_memory_mib", peak_memory_mib());
        for (std::size_t joint = 0; joint < volume_changes.size(); ++joint) {
            const std::vector<double>& changes = volume_changes[joint];
            report.add(flesh_joint_names()[joint] + "_volume_change_mean",
                       std::accumulate(changes.begin(), changes.end(), 0.0) / samples);
            report.add(flesh_joint_names()[joint] + "_volume_change_5_percent", bench::quantile(changes, 0.05));
        }
        if (plain_done > 0) {
            report.add("plain_converged_share", static_cast<double>(plain_converged) / plain_done);
            report.add("plain_seconds_ratio", plain_seconds / same_seconds);
        }
        report.add("set_body_seconds", body_seconds / static_cast<double>(bench.bodies.size()));
        report.add("energy_seconds", seconds_of([&] { objective.energy(last); }));
        report.add("gradient_seconds", seconds_of([&] { objective.gradient(last, gradient, absolute); }));
        for (const auto& [name, kind] :
             std::vector<std::pair<std::string, HessianKind>>{{"gauss_newton", HessianKind::gauss_newton},
                                                              {"exact", HessianKind::exact},
                                                              {"projected", HessianKind::projected}}) {
            report.add(name + "_hessian_seconds",
                       seconds_of([&, hessian_kind = kind] { objective.hessian(last, hessian_kind, hessian); }));
        }
        report.add("factor_seconds", seconds_of([&] { single.factorize(hessian); }));
        report.add("solve_seconds", seconds_of([&] { single.solve(gradient, solution); }));
        report.add("double_factor_seconds", seconds_of([&] { cholesky.factorize(hessian); }));
        report.add("double_solve_seconds", seconds_of([&] { cholesky.solve(gradient); }));
        report.add("factor_nonzeros", static_cast<double>(single.factor_nonzeros()));
        report.print();
        if (!output.empty()) report.write(output);
    });
}
