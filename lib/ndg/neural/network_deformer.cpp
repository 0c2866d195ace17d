// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/network_deformer.h"

#include "ndg/core/error.h"

namespace ndg {

namespace {

NeuralModel load_model(const BodyPoser& poser, const NetworkInputs& inputs)
{
    require_input(!inputs.model_path.empty(), "a network needs --model");
    require_available(inputs.device);
    NeuralModel model = NeuralModel::load(inputs.model_path, poser.body_template(), inputs.device);
    const BoneWrap learned = model.options().posing.bone_wrap, given = poser.options().bone_wrap;
    require_input(learned == given, "{}: was trained on bodies posed with bone-wrap {}, these are posed with {}",
                  inputs.model_path, to_name(learned), to_name(given));
    return model;
}

}  // namespace

void NetworkInputs::add_to(Tool& tool, bool required)
{
    tool.input("model", model_path, "trained network", required);
    tool.parameter("batch-size", batch_size, "samples that go through the network together", 1, 4096);
    tool.parameter("device", device, "where the network runs");
}

NetworkDeformer::NetworkDeformer(const BodyPoser& poser, const NetworkInputs& inputs)
    : model_(load_model(poser, inputs)), batch_size_(inputs.batch_size), rest_(poser.body_template())
{
}

RowMatrixF NetworkDeformer::predict(const std::vector<PosedBody>& posed)
{
    std::vector<PoseInput> inputs;
    for (const PosedBody& one : posed) {
        const auto [code, is_new] = codes_.try_emplace(&one.body());
        if (is_new) code->second = model_.input_space().encode(one.body());
        inputs.push_back({code->second, one.pose()});
    }
    return model_.predict(inputs);
}

std::vector<GradientsF> NetworkDeformer::gradients(const std::vector<PosedBody>& posed)
{
    const RowMatrixF predictions = predict(posed);
    std::vector<GradientsF> gradients;
    for (std::size_t i = 0; i < posed.size(); ++i)
        gradients.push_back(model_.output_space().gradients(posed[i], predictions.row(i).data()));
    return gradients;
}

std::vector<Points> NetworkDeformer::deform_batch(const std::vector<PosedBody>& posed)
{
    const RowMatrixF predictions = predict(posed);
    std::vector<Points> vertices;
    for (std::size_t i = 0; i < posed.size(); ++i)
        vertices.push_back(model_.output_space().vertices(posed[i], rest_, predictions.row(i).data()));
    return vertices;
}

void register_network_deformer(MethodTable& table)
{
    const auto inputs = std::make_shared<NetworkInputs>();
    const auto make = [inputs](const std::string& output_space) {
        return [inputs, output_space](const BodyPoser& poser) {
            auto network = std::make_unique<NetworkDeformer>(poser, *inputs);
            require_input(network->options().output_space == output_space,
                          "{}: a model that predicts {}, where this method needs one of {}", inputs->model_path,
                          network->options().output_space, output_space);
            return network;
        };
    };
    table.add({"ndg", "NDG", "a trained network: deformation gradients, then a Poisson solve",
               [inputs](Tool& tool) { inputs->add_to(tool, false); }, make("residuals")});
    table.add({"vertexnet",
               "VertexNet",
               "a trained network: offsets of vertices, then linear blend skinning",
               {},
               make("vertex-offsets")});
}

}  // namespace ndg
