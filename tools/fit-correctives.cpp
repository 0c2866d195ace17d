// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/deform/fit_correctives.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("fit-correctives", "Fits blend shapes that are linear in the pose to the training samples.",
              "fit-correctives --template template.h5 --bodies bodies.h5 --poses poses.h5 --samples fem.h5 "
              "--output correctives.h5");
    SampleInputs inputs;
    CorrectivesOptions options;
    std::string samples_path, output_path;
    inputs.add_files(tool);
    tool.input("samples", samples_path, "simulated samples; those of the train split are fitted");
    tool.output("output", output_path, "blend shapes to write");
    tool.options(options);
    return tool.run(argc, argv, [&] {
        inputs.read();
        const DeformationSet samples = open_deformations(samples_path, inputs.body_template.num_volume_vertices());
        const CorrectivesFit fit = fit_correctives(inputs.body_template, inputs.bodies, inputs.poses, samples, options);
        write_correctives(output_path, fit.correctives, inputs.body_template, tool.provenance());
        fmt::print("{}: {} blend shapes of {} joints, ridge {:g}; {} samples left out that did not converge\n",
                   output_path, fit.correctives.blend_shapes.rows(), fit.correctives.joints.size(),
                   fit.correctives.ridge, fit.num_unconverged);
        const auto print = [](const char* split, int count, double without, double error) {
            fmt::print("{:>10}: {} samples, root mean square offset {:.3f} mm, {:.3f} mm without correctives\n", split,
                       count, 1e3 * error, 1e3 * without);
        };
        print("train", fit.num_train, fit.train_without, fit.train_error);
        if (fit.num_validation > 0)
            print("validation", fit.num_validation, fit.validation_without, fit.validation_error);
    });
}
