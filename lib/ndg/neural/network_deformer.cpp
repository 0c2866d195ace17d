// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/network_deformer.h"

#include "ndg/core/error.h"

namespace ndg {

namespace {

NdgModel load_model(const Template& body_template, const NetworkInputs& inputs)
{
    require_input(!inputs.model_path.empty(), "a network needs --model");
    return NdgModel::load(inputs.model_path, body_template, body_template.file_sha256, parse_device(inputs.device));
}

}  // namespace

void NetworkInputs::add_to(Tool& tool, bool required)
{
    tool.input("model", model_path, "trained network", required);
    tool.parameter("batch-size", batch_size, "samples that go through the network together", 1, 4096);
    tool.parameter("device", device, "where the network runs", {"cpu", "cuda"});
}

NetworkDeformer::NetworkDeformer(const Template& body_template, const NetworkInputs& inputs)
    : model_(load_model(body_template, inputs)), batch_size_(inputs.batch_size), rest_(body_template)
{
}

std::vector<GradientsF> NetworkDeformer::gradients(const std::vector<PosedBody>& posed)
{
    std::vector<PoseInput> inputs;
    for (const PosedBody& one : posed) {
        const auto [code, is_new] = codes_.try_emplace(&one.body());
        if (is_new) code->second = model_.encode(one.body());
        inputs.push_back({code->second, one.pose()});
    }
    return model_.predict_gradients(inputs);
}

std::vector<Points> NetworkDeformer::deform_batch(const std::vector<PosedBody>& posed)
{
    const std::vector<GradientsF> predicted = gradients(posed);
    std::vector<Points> vertices;
    for (std::size_t i = 0; i < posed.size(); ++i) {
        vertices.push_back(rest_.poisson(posed[i].body()).reconstruct(predicted[i], posed[i].bone_wrap()));
    }
    return vertices;
}

void register_network_deformer(MethodTable& table)
{
    const auto inputs = std::make_shared<NetworkInputs>();
    table.add({"ndg", "NDG", "deformation gradients by a trained network, then a Poisson solve",
               [inputs](Tool& tool) { inputs->add_to(tool, false); },
               [inputs](const Template& body_template) {
                   return std::make_unique<NetworkDeformer>(body_template, *inputs);
               }});
}

}  // namespace ndg
