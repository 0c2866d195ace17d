// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/gradient_file.h"
#include "ndg/deform/animate.h"
#include "ndg/neural/network_deformer.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "infer-ndg", "Predicts deformation gradients with a trained network.",
        "infer-ndg --model model.h5 --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
        "--split test --output gradients.h5");
    SampleInputs inputs;
    NetworkInputs network_inputs;
    std::string output, method;
    network_inputs.add_to(tool, true);
    inputs.add_files(tool);
    inputs.add_samples(tool);
    inputs.add_posing(tool);
    tool.output("output", output, "deformation gradients to write");
    tool.parameter("method", method, "name of the predictions in tables, instead of the model's");
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        inputs.read();
        NetworkDeformer network(BodyPoser(inputs.body_template, inputs.samples.posing), network_inputs);
        inputs.samples.method = method.empty() ? network.name() : method;
        const int num_prisms = inputs.body_template.num_prisms();
        GradientWriter writer(output, inputs.samples, num_prisms, tool.provenance());
        for_each_posed_batch(inputs, network.batch_size(), "predicting",
                             [&](const std::vector<int>& sample_indices, const std::vector<PosedBody>& posed) {
                                 const std::vector<GradientsF> gradients = network.gradients(posed);
                                 for (std::size_t k = 0; k < posed.size(); ++k) {
                                     writer.write(sample_indices[k], gradients[k]);
                                 }
                             });
        writer.commit();
        fmt::print("{}: {} samples of {} prisms\n", output, inputs.samples.size(), num_prisms);
    });
}
