// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool.h"
#include "ndg/runtime/export_model.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("export-runtime",
              "Writes a trained network for libndg: weights in 8 bits (or as --last-layer and --hidden-layers say) in "
              "the order in which a frame reads them, one file that is mapped into memory.",
              "export-runtime --model model.h5 --output model.ndg");
    std::string model_path, output_path;
    RuntimeWeights weights;
    tool.input("model", model_path, "trained network");
    tool.options(weights);
    tool.output("output", output_path, "runtime model to write");
    return tool.run(argc, argv, [&] {
        export_runtime_model(model_path, weights, output_path, tool.provenance());
        const RuntimeModel model(output_path);
        fmt::print("{}: {} weights in {:.1f} MB\n", output_path, model.num_weights(),
                   1e-6 * static_cast<double>(model.weight_bytes()));
    });
}
