// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/release/cards.h"
#include "ndg/release/onnx_network.h"
#include "ndg/release/safetensors.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "export-release",
        "Writes a trained network for other programs: its numbers as safetensors, how they are put together as "
        "JSON, its graph as ONNX, and cards of model and data in Markdown (docs/release.md). Needs no libtorch.",
        "export-release --model model.h5 --safetensors model.safetensors --config-json config.json --onnx model.onnx");
    ReleaseInputs inputs;
    OnnxOptions onnx;
    std::string safetensors_path, config_path, onnx_path, model_card_path, dataset_card_path;
    inputs.name = "NDG";
    tool.input("model", inputs.model_path, "trained network");
    tool.input("tables", inputs.tables_path, "tables.json of evaluate-metrics, for the model's card", false);
    tool.input("data", inputs.data_paths, "files of the data set, in the order of their making, for its card", false);
    tool.parameter("name", inputs.name, "of the release");
    tool.options(onnx);
    tool.output("safetensors", safetensors_path, "numbers of the network", false);
    tool.output("config-json", config_path, "how they are put together", false);
    tool.output("onnx", onnx_path, "graph of the network", false);
    tool.output("model-card", model_card_path, "card of the model, Markdown", false);
    tool.output("dataset-card", dataset_card_path, "card of the data, Markdown", false);
    return tool.run(argc, argv, [&] {
        bool asked = false;
        for (const std::string& path : {safetensors_path, config_path, onnx_path, model_card_path, dataset_card_path})
            asked = asked || !path.empty();
        require_input(asked,
                      "give --safetensors, --config-json, --onnx, --model-card, --dataset-card or several of them");
        if (!safetensors_path.empty()) write_safetensors(safetensors_path, inputs.model_path);
        if (!config_path.empty()) write_file(config_path, network_config(inputs.model_path));
        if (!onnx_path.empty()) write_onnx(onnx_path, inputs.model_path, onnx);
        if (!model_card_path.empty()) write_file(model_card_path, model_card(inputs));
        if (!dataset_card_path.empty()) write_file(dataset_card_path, dataset_card(inputs));
    });
}
