// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/deform/animate.h"
#include "ndg/deform/stored_gradients.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("reconstruct", "Turns deformation gradients into vertices, and into embedded anatomy if wanted.",
              "reconstruct --template template.h5 --bodies bodies.h5 --poses poses.h5 --gradients gradients.h5 "
              "--output ndg.h5");
    SampleInputs inputs;
    AnimationOutputs outputs;
    std::string gradients_path;
    inputs.add_files(tool);
    tool.input("gradients", gradients_path, "deformation gradients of samples");
    tool.output("output", outputs.deformations, "deformed samples");
    tool.output("anatomy", outputs.anatomy, "embedded anatomy of every sample", false);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        inputs.read();
        StoredGradients gradients(inputs.body_template, gradients_path);
        inputs.samples = gradients.index();
        animate_samples(inputs, gradients, gradients.name(), outputs, tool.provenance());
        fmt::print("{} samples of {} reconstructed\n", inputs.samples.size(), gradients.name());
    });
}
