// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/tool.h"
#include "ndg/neural/torchscript.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "export-network",
        "Writes a trained network as TorchScript: torch.jit.load(\"model.pt\")(parent_from_joint, rest_volume) in "
        "Python, with rotations of the pose (B x J x 3 x 3) and volume vertices of the bodies at rest (B x N_v x "
        "3, m), gives what the network predicts.",
        "export-network --model model.h5 --template template.h5 --output model.pt");
    std::string template_path, model_path, output_path;
    tool.input("model", model_path, "trained network");
    tool.input("template", template_path, "the template it was trained on");
    tool.output("output", output_path, "TorchScript to write");
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        NeuralModel model = NeuralModel::load(model_path, body_template);
        write_torchscript(output_path, model, tool.provenance());
        fmt::print("{}: {}, {} weights\n", output_path, method_name(model.options()), model.num_parameters());
    });
}
