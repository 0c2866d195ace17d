// SPDX-License-Identifier: Apache-2.0
// Poisson reconstruction: factor once a body, then right-hand side and back-substitution a frame. Without --template:
// a tube.
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/deform/poisson.h"
#include "ndg/deform/posed_body.h"
#include "ndg/geometry/prism.h"
#include "report.h"
#include "support/support.h"

#include <omp.h>

#include <chrono>

using namespace ndg;

namespace {

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-reconstruction", "Times the Poisson reconstruction on one core.",
              "bench_reconstruction --frames 100 --output out/bench/reconstruction.json");
    std::string template_path, output;
    int frames = 50, rings = 100;
    tool.input("template", template_path, "template; the built-in tube without it", false);
    tool.parameter("frames", frames, "frames to reconstruct", 1, 100000);
    tool.parameter("rings", rings, "rings of the tube", 3, 100000);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        set_num_threads(1);
        omp_set_max_active_levels(0);  // CHOLMOD's own parallel sections too
        const Template body_template =
            template_path.empty() ? test::tube_template(rings, 16) : read_template(template_path);
        const BodyPoser poser(body_template, template_path.empty() ? test::bending : PosingOptions{});
        const Body& body = body_template.rest;

        auto start = std::chrono::steady_clock::now();
        const RestOperators rest(body_template.prisms, body.volume_vertices);
        PoissonReconstruction poisson(rest, body_template.num_wrap_vertices());
        const double first_seconds = seconds_since(start);
        start = std::chrono::steady_clock::now();
        poisson.set_rest(RestOperators(body_template.prisms, body.volume_vertices));
        const double set_rest_seconds = seconds_since(start);

        const PosedBody posed = poser.pose(body, test::tube_pose(0.8));
        const Points expected = posed.skinned_volume();
        const Gradients gradients = rest.deformation_gradients(expected);
        const GradientsF single = gradients.cast<float>();
        std::vector<double> seconds;
        double error = 0;
        for (int i = 0; i < frames; ++i) {
            start = std::chrono::steady_clock::now();
            const Points vertices = poisson.reconstruct(single, posed.bone_wrap());
            seconds.push_back(seconds_since(start));
            error = (vertices - expected).rowwise().norm().maxCoeff();
        }
        bench::Report report("reconstruction");
        report.add("prisms", body_template.num_prisms());
        report.add("free_vertices", 2.0 * body_template.num_wrap_vertices());
        report.add("analyze_and_factor_seconds", first_seconds);
        report.add("set_rest_seconds", set_rest_seconds);
        report.add("frame_seconds_median", bench::quantile(seconds, 0.5));
        report.add("frame_seconds_p95", bench::quantile(seconds, 0.95));
        report.add("factor_nonzeros", poisson.factor_nonzeros());
        report.add("error_max_metre", error);
        report.print();
        if (!output.empty()) report.write(output);
    });
}
