// SPDX-License-Identifier: Apache-2.0
// Core-seconds of one FEM sample, and where they go. Without --template: a bent tube.
#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/fem/simulation_parameters.h"
#include "report.h"
#include "support/support.h"

#include "ndg/body/pose_set.h"

#include <omp.h>

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

struct Case {
    Template body_template;
    std::vector<Body> bodies;
    std::vector<Pose> poses;
};

Case read_case(const std::string& template_path, const std::string& bodies_path, const std::string& poses_path,
               int samples, int rings)
{
    Case result;
    if (template_path.empty()) {
        result.body_template = test::tube_template(rings, 16);
        result.bodies = {result.body_template.rest};
        for (int i = 0; i < samples; ++i) result.poses.push_back(test::tube_pose(0.3 + 1.5 * i / samples));
        return result;
    }
    result.body_template = read_template(template_path);
    result.bodies = bodies_path.empty() ? std::vector<Body>{result.body_template.rest}
                                        : read_bodies(bodies_path, result.body_template).bodies;
    require_input(!poses_path.empty(), "--poses must be given with --template");
    const PoseSet poses = read_poses(poses_path);
    for (int i = 0; i < samples; ++i) {
        result.poses.push_back(poses.poses[static_cast<std::size_t>(static_cast<long>(i) * poses.size() / samples)]);
    }
    return result;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-fem", "Times FEM samples on one core.", "bench_fem --samples 20 --output out/bench/fem.json");
    std::string template_path, bodies_path, poses_path, output;
    int samples = 12, rings = 100;
    SimulationOptions options;
    tool.input("template", template_path, "template; the built-in tube without it", false);
    tool.input("bodies", bodies_path, "bodies; the template's own without it", false);
    tool.input("poses", poses_path, "poses, spread evenly over the samples", false);
    tool.parameter("samples", samples, "samples to simulate", 1, 100000);
    tool.parameter("rings", rings, "rings of the tube", 3, 100000);
    add_simulation_parameters(tool, options);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        set_num_threads(1);
        omp_set_max_active_levels(0);  // CHOLMOD's own parallel sections too
        const Case bench = read_case(template_path, bodies_path, poses_path, samples, rings);
        Simulator simulator(bench.body_template, options);
        std::vector<double> seconds, iterations, factorizations;
        int converged = 0, stepped = 0;
        double inverted = 0;
        Points last;
        for (int i = 0; i < samples; ++i) {
            SimulationResult result;
            seconds.push_back(seconds_of([&] {
                simulator.set_body(bench.bodies[static_cast<std::size_t>(i) % bench.bodies.size()]);
                result = simulator.simulate(bench.poses[static_cast<std::size_t>(i)]);
            }));
            iterations.push_back(result.newton.iterations);
            factorizations.push_back(result.newton.factorizations);
            converged += result.newton.converged();
            stepped += result.load_steps > 0;
            inverted += result.inverted_prisms;
            last = result.vertices;
            fmt::print(
                stderr,
                "sample {:3d}: {:.2f} s (relax {:.2f}, assemble {:.2f}, factor {:.2f}, solve {:.2f}, evaluate {:.2f}), "
                "{:2d} iterations, {:2d} factorizations, {:2d} cg, {}, |g| {:.1e} N, relative {:.1e}, {} inverted\n",
                i, seconds.back(), result.newton.seconds.relaxation, result.newton.seconds.assembly,
                result.newton.seconds.factorization, result.newton.seconds.substitution,
                result.newton.seconds.evaluation, result.newton.iterations, result.newton.factorizations,
                result.newton.cg_iterations, describe(result.newton.stop), result.newton.residual_newton,
                result.newton.residual_relative, result.inverted_prisms);
        }

        const ElasticSystem& model = simulator.system();
        Eigen::SparseMatrix<double> hessian = model.hessian_pattern();
        SparseCholesky cholesky(SparseCholesky::Method::supernodal);
        cholesky.analyze(hessian);
        Eigen::VectorXd gradient, absolute;
        bench::Report report("fem");
        report.add("prisms", static_cast<double>(model.model().prisms().rows()));
        report.add("unknowns", model.num_unknowns());
        report.add("core_seconds_median", bench::quantile(seconds, 0.5));
        report.add("core_seconds_p95", bench::quantile(seconds, 0.95));
        report.add("iterations_median", bench::quantile(iterations, 0.5));
        report.add("factorizations_median", bench::quantile(factorizations, 0.5));
        report.add("core_seconds_mean", std::accumulate(seconds.begin(), seconds.end(), 0.0) / samples);
        report.add("iterations_max", bench::quantile(iterations, 1.0));
        report.add("converged_share", static_cast<double>(converged) / samples);
        report.add("load_stepped_share", static_cast<double>(stepped) / samples);
        report.add("inverted_prisms_mean", inverted / samples);
        report.add("set_body_seconds", seconds_of([&] { simulator.set_body(bench.bodies.front()); }));
        report.add("energy_seconds", seconds_of([&] { model.energy(last); }));
        report.add("gradient_seconds", seconds_of([&] { model.gradient(last, gradient, absolute); }));
        report.add("exact_hessian_seconds", seconds_of([&] { model.hessian(last, HessianKind::exact, hessian); }));
        report.add("projected_hessian_seconds",
                   seconds_of([&] { model.hessian(last, HessianKind::projected, hessian); }));
        report.add("factor_seconds", seconds_of([&] { cholesky.factorize(hessian); }));
        report.add("solve_seconds", seconds_of([&] { cholesky.solve(gradient); }));
        report.add("factor_nonzeros", cholesky.factor_nonzeros());
        report.print();
        if (!output.empty()) report.write(output);
    });
}
