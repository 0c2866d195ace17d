// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/dynamics/avatar_body.h"
#include "ndg/estimation/estimate_tissue.h"
#include "ndg/scene/line_chart.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace {

using namespace ndg;

std::vector<std::string> names_in(const std::string& text)
{
    std::vector<std::string> names;
    std::istringstream stream(text);
    for (std::string name; std::getline(stream, name, ',');) {
        if (!name.empty()) names.push_back(name);
    }
    return names;
}

/// Correlation of the logarithms of two fields over the measured skin, of `young` what a twin's truth is compared with.
double field_correlation(const Eigen::VectorXd& young, const MeasuredSkin& skin, const std::vector<double>& truth)
{
    Eigen::ArrayXd a(skin.size()), b(skin.size());
    for (int v = 0; v < skin.size(); ++v) {
        const auto k = static_cast<std::size_t>(v);
        a[v] = std::log(young[skin.volume_vertices[k]]);
        b[v] = std::log(truth[static_cast<std::size_t>(skin.skin_vertices[k])]);
    }
    a -= a.mean();
    b -= b.mean();
    return (a * b).sum() / std::sqrt(std::max(a.square().sum() * b.square().sum(), 1e-300));
}

Image convergence_chart(const TissueEstimate& estimate)
{
    ChartLine line;
    line.name = "all training sequences";
    line.colour = {60, 90, 160};
    for (std::size_t i = 0; i < estimate.iterations.size(); ++i) {
        line.x.push_back(static_cast<double>(i));
        line.y.push_back(std::max(estimate.iterations[i].error, 1e-12));
    }
    ChartLine skinned = line;
    skinned.name = "statistical body alone";
    skinned.colour = {190, 60, 60};
    std::fill(skinned.y.begin(), skinned.y.end(), 1.0);
    return line_chart({line, skinned}, {"Convergence", "iteration", "share of the error left"});
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("estimate-tissue",
              "Finds the stiffness of a person's soft tissue with which it moves as captured. Resumable.",
              "estimate-tissue --avatar avatar.h5 --capture capture.h5 --train jumping_jacks,running --output "
              "stiffness.json --report estimate.json");
    std::string avatar_path, capture_path, output_path, report_path, chart_path, train;
    EstimationOptions options;
    DynamicsOptions dynamics;
    TissueOptions tissue;
    bool with_tests = true;
    tool.input("avatar", avatar_path, "avatar of the captured person (make-avatar)");
    tool.input("capture", capture_path, "capture with poses (import-capture, simulate-capture)");
    tool.output("output", output_path, "moduli at the avatar's control points, for simulate-dynamics --stiffness-field",
                true, true);
    tool.output("report", report_path, "errors, convergence and all figures, JSON", true, true);
    tool.output("chart", chart_path, "PNG of the convergence", false, true);
    tool.parameter("train", train, "sequences to estimate from, by commas; all without it. The others test");
    tool.parameter("tests", with_tests, "simulate the other sequences with the estimate");
    tool.options(options);
    tool.options(tissue);
    tool.parameter("step-rate", dynamics.step_rate_hertz, "time steps a second", 1.0, 1e5);
    tool.parameter("density", dynamics.density, "density of the flesh, kg/m^3", 1.0, 1e5);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        const Avatar avatar = read_avatar(avatar_path);
        const Capture capture = read_capture(capture_path);
        require_input(capture.has_poses(), "{}: the capture has no poses", capture_path);
        const MeasuredSkin skin(avatar);
        std::vector<std::string> trained = names_in(train);
        for (const std::string& name : trained) capture.sequence(name);
        if (trained.empty()) {
            for (const CaptureSequence& sequence : capture.sequences) trained.push_back(sequence.name);
        }
        VarianceProblem problem;
        problem.tissue = soft_body_of(avatar, {});
        problem.poser = poser_of(avatar);
        problem.options = tissue;
        problem.dynamics = dynamics;
        problem.volume_vertices = skin.volume_vertices;
        problem.normals = skin.normals;
        std::vector<TargetMotion> training, testing;
        std::vector<std::string> test_names;
        for (const CaptureSequence& sequence : capture.sequences) {
            const bool is_trained = std::count(trained.begin(), trained.end(), sequence.name) > 0;
            if (!is_trained && !with_tests) continue;
            (is_trained ? training : testing)
                .push_back(target_motion(avatar, skin, sequence, dynamics.step_rate_hertz));
            if (!is_trained) test_names.push_back(sequence.name);
        }

        OptionList list;
        describe(list, options);
        describe(list, tissue);
        EstimationRun run;
        run.checkpoint = report_path + ".checkpoint";
        run.key = run_key("estimate-tissue", estimation_method_version,
                          fmt::format("{} {} {} {}", options_key(list), dynamics.step_rate_hertz, dynamics.density,
                                      fmt::join(trained, ",")),
                          data_hashes(tool.provenance()));
        run.force = tool.force();
        run.stop = interrupt_requested;
        run.tell = [](const EstimationIteration& i) {
            log_info("stage {}, iteration {}: {:.4f} of the statistical body's error, {} simulations, {:.0f} s",
                     i.stage, i.iteration, i.error, i.simulations, i.seconds);
        };
        const TissueEstimate estimate = estimate_tissue(problem, training, avatar.control_weights, options, run);
        const std::vector<double> test_errors =
            estimated_errors(problem, testing, avatar.control_weights, estimate.young_normal_pascal,
                             estimate.young_tangent_pascal, options.metric());
        write_file(output_path, stiffness_field_json(estimate));
        write_file(report_path, estimate_json(estimate, options, test_names, test_errors));
        if (!chart_path.empty()) write_png(chart_path, convergence_chart(estimate));

        fmt::print("{:<28} {:>10}\n", "variance error left", "share");
        fmt::print("{:<28} {:>10.4f}\n{:<28} {:>10.4f}\n{:<28} {:>10.4f}\n", "statistical body", 1.0, "one stiffness",
                   estimate.uniform_error, "at control points", estimate.error);
        for (std::size_t s = 0; s < training.size(); ++s)
            fmt::print("  {:<26} {:>10.4f}  training\n", training[s].name, estimate.sequence_errors[s]);
        for (std::size_t s = 0; s < testing.size(); ++s)
            fmt::print("  {:<26} {:>10.4f}  test\n", test_names[s], test_errors[s]);
        fmt::print("moduli along the normal, kPa: {:.1f}\nmoduli along the skin, kPa: {:.1f}\n",
                   fmt::join(
                       [&] {
                           std::vector<double> kilo = estimate.young_normal_pascal;
                           for (double& value : kilo) value *= 1e-3;
                           return kilo;
                       }(),
                       " "),
                   fmt::join(
                       [&] {
                           std::vector<double> kilo = estimate.young_tangent_pascal;
                           for (double& value : kilo) value *= 1e-3;
                           return kilo;
                       }(),
                       " "));
        if (!capture.true_stiffness.empty()) {
            const auto field = [&](const std::vector<double>& values) {
                return Eigen::VectorXd(
                    avatar.control_weights *
                    Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
            };
            fmt::print("correlation with the twin's hidden stiffness: {:.2f} along the normal, {:.2f} along the skin\n",
                       field_correlation(field(estimate.young_normal_pascal), skin, capture.true_stiffness),
                       field_correlation(field(estimate.young_tangent_pascal), skin, capture.true_stiffness));
        }
        std::filesystem::remove(run.checkpoint);
    });
}
