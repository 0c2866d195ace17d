// SPDX-License-Identifier: Apache-2.0
// Reading and writing format "ndg-model", version 2.
#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/neural/model_state.h"
#include "ndg/runtime/model_traits.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace ndg {
namespace {

std::string join(const std::vector<int>& values)
{
    std::string text;
    for (const int value : values) text += (text.empty() ? "" : ",") + std::to_string(value);
    return text;
}

std::vector<int> read_integers(const H5Reader& file, const std::string& name)
{
    const std::string text = file.attribute(name);
    std::vector<int> values;
    std::istringstream stream(text);
    for (std::string item; std::getline(stream, item, ',');) {
        try {
            values.push_back(std::stoi(item));
        } catch (const std::exception&) {
            throw InputError(
                fmt::format("{}: attribute {} is \"{}\", not a list of integers", file.path(), name, text));
        }
    }
    return values;
}

void write_tensor(H5Writer& file, const std::string& name, const torch::Tensor& tensor, const std::string& description)
{
    const RowMatrixF values = TorchNetwork::matrix(tensor);
    std::vector<std::size_t> shape;
    for (const std::int64_t extent : tensor.sizes()) shape.push_back(static_cast<std::size_t>(extent));
    file.write(name, shape, values.data(), description);
}

/// Reads into `tensor`, whose shape the file must have.
void read_tensor(const H5Reader& file, const std::string& name, torch::Tensor& tensor)
{
    const torch::NoGradGuard no_grad;
    if (tensor.dim() == 1) {
        const std::vector<double> values = file.read_doubles(name, tensor.size(0));
        for (std::size_t i = 0; i < values.size(); ++i) tensor.data_ptr<float>()[i] = static_cast<float>(values[i]);
        return;
    }
    Eigen::Map<RowMatrixF>(tensor.data_ptr<float>(), tensor.size(0), tensor.size(1)) =
        file.read_matrix(name, tensor.size(0), tensor.size(1)).cast<float>();
}

/// What belongs to a part of a network, and to none of its layers, stands here.
std::string group_of(const Network& network, std::size_t part_idx)
{
    return network.parts[part_idx].outputs.defined() ? fmt::format("/network/region_{}", part_idx) : "/network";
}

/// Calls f(name, tensor, description) for every tensor of a part of the network.
template <typename F>
void for_tensors(Network& all, std::size_t part_idx, const F& f)
{
    TorchNetwork& network = all.parts[part_idx].perceptron;
    const std::string region = all.parts[part_idx].outputs.defined() ? std::to_string(part_idx) + "_" : "";
    for (std::size_t i = 0; i < network.layers.size(); ++i) {
        const std::string group = fmt::format("/network/layer_{}{}/", region, i);
        TorchNetwork::Layer& layer = network.layers[i];
        f(group + "weight", layer.weight, "outputs x inputs");
        f(group + "bias", layer.bias, "outputs");
        if (!layer.norm_weight.defined()) continue;
        f(group + "norm_weight", layer.norm_weight, "scale of LayerNorm, outputs");
        f(group + "norm_bias", layer.norm_bias, "offset of LayerNorm, outputs");
    }
    if (network.basis.defined())
        f(group_of(all, part_idx) + "/output_basis", network.basis,
          "coefficients x outputs: fixed map from the last layer to the raw outputs");
}

int read_count(const H5Reader& file, const std::string& name)
{
    const double value = file.attribute_double(name);
    require_input(value >= 0 && value <= 1e9 && value == std::floor(value), "{}: attribute {} is {}, not a count",
                  file.path(), name, value);
    return static_cast<int>(value);
}

NetworkOptions read_options(const H5Reader& file)
{
    NetworkOptions options;
    const ModelTraits traits = read_model_traits(file);
    options.output_space = traits.output_space;
    options.parametrisation = traits.parametrisation;
    options.rotation = traits.rotation;
    options.shape = traits.shape;
    options.posing = traits.posing;
    options.widths = read_integers(file, "widths");
    // Files from before there was a choice are of one network.
    if (file.has_attribute("region_reach")) {
        const std::vector<int> reach = read_integers(file, "region_reach");
        require_input(reach.size() == 1, "{}: attribute region_reach has {} numbers", file.path(), reach.size());
        options.region_reach = reach[0];
    }
    options.output_basis = read_count(file, "output_basis");
    try {
        options.check();
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", file.path(), error.what()));
    }
    return options;
}

/// The network of a model with these options and columns, from the file; refused where the columns are others.
Network read_network(const H5Reader& file, const NeuralModel::State& state)
{
    std::vector<RowMatrixF> bases;
    Network network = state.new_network({});
    for (std::size_t i = 0; i < network.parts.size() && state.options.output_basis > 0; ++i) {
        const std::vector<std::size_t> shape = file.shape(group_of(network, i) + "/output_basis");
        require_input(shape.size() == 2, "{}: {}/output_basis is no matrix", file.path(), group_of(network, i));
        const auto num_outputs =
            state.columns.empty() ? state.output_space->width() : static_cast<int>(state.columns[i].outputs.size());
        bases.push_back(RowMatrixF::Zero(static_cast<Eigen::Index>(shape[0]), num_outputs));
    }
    if (!bases.empty()) network = state.new_network(bases);
    for (std::size_t i = 0; i < network.parts.size(); ++i) {
        const std::string group = group_of(network, i);
        for_tensors(network, i, [&](const std::string& name, torch::Tensor& tensor, const char*) {
            read_tensor(file, name, tensor);
        });
        if (state.columns.empty()) continue;
        for (const auto& [name, columns] : {std::pair(group + "/inputs", &state.columns[i].inputs),
                                            std::pair(group + "/outputs", &state.columns[i].outputs)})
            require_input(file.read_ints(name, -1, 0, 1 << 30) == *columns,
                          "{}: {} does not fit the regions of the template", file.path(), name);
    }
    return network;
}

TrainingCurve read_curve(const H5Reader& file)
{
    TrainingCurve curve;
    curve.best_epoch = read_count(file, "best_epoch");
    curve.initial_train_loss = file.attribute_double("initial_train_loss");
    curve.initial_validation_loss = file.attribute_double("initial_validation_loss");
    if (!file.has("/training/epoch")) return curve;  // never trained
    curve.epoch = file.read_ints("/training/epoch", -1, 1, 1 << 30);
    curve.train_loss = file.read_doubles("/training/train_loss", static_cast<std::int64_t>(curve.epoch.size()));
    curve.validation_loss =
        file.read_doubles("/training/validation_loss", static_cast<std::int64_t>(curve.epoch.size()));
    return curve;
}

}  // namespace

void NeuralModel::save(const std::string& path, const Provenance& provenance) const
{
    State& state = *state_;
    const ShapeSpace& space = state.input_space.shape_space();
    H5Writer file(path, model_format, model_version, provenance);
    file.attribute("output_space", state.options.output_space);
    write_posing(file, state.options.posing);
    file.attribute("widths", join(state.options.widths));
    file.attribute("parametrisation", to_name(state.options.parametrisation));
    file.attribute("rotation", std::string(state.options.rotation ? "true" : "false"));
    file.attribute("shape", std::string(state.options.shape ? "true" : "false"));
    if (state.options.region_reach > 0) file.attribute("region_reach", std::to_string(state.options.region_reach));
    std::int64_t most_coefficients = 0;
    for (const torch::Tensor& basis : state.network.bases())
        most_coefficients = std::max(most_coefficients, basis.size(0));
    file.attribute("output_basis", static_cast<double>(most_coefficients));
    file.attribute("template_sha256", state.template_sha256);
    file.attribute("explained_variance", space.explained_variance);
    if (!state.precision.empty()) file.attribute("precision", state.precision);
    file.attribute("best_epoch", static_cast<double>(state.curve.best_epoch));
    file.attribute("initial_train_loss", state.curve.initial_train_loss);
    file.attribute("initial_validation_loss", state.curve.initial_validation_loss);
    file.write("/input/joint_names", state.input_space.joint_names(), "order of the rotation matrices in the input");
    file.write("/input/visible_joints", state.input_space.visible_joints(),
               "1 where the input contains the joint's rotation, otherwise 0");
    for (std::size_t i = 0; i < state.network.parts.size(); ++i) {
        const std::string group = group_of(state.network, i);
        for_tensors(state.network, i,
                    [&](const std::string& name, const torch::Tensor& tensor, const char* description) {
                        write_tensor(file, name, tensor, description);
                    });
        if (state.columns.empty()) continue;
        file.write(group + "/inputs", state.columns[i].inputs, "columns of the input that the region's network sees");
        file.write(group + "/outputs", state.columns[i].outputs, "columns of the raw outputs that it gives");
    }
    file.write("/shape_space/mean", std::vector<double>(space.mean.data(), space.mean.data() + space.mean.size()),
               "mean rest shape, 3 N_v, m");
    file.write("/shape_space/components", RowMatrix(space.components), "3 N_v x d, orthonormal columns",
               Storage::float64);
    file.write("/shape_space/standard_deviations",
               std::vector<double>(space.standard_deviations.data(),
                                   space.standard_deviations.data() + space.standard_deviations.size()),
               "of the training codes, d, m; codes are divided by the largest");
    if (!state.curve.epoch.empty()) {
        file.write("/training/epoch", state.curve.epoch, "1, 2, ...");
        file.write("/training/train_loss", state.curve.train_loss, "mean squared error of the epoch's batches");
        file.write("/training/validation_loss", state.curve.validation_loss, "mean squared error after the epoch");
    }
    file.commit();
}

NeuralModel NeuralModel::load(const std::string& path, const Template& body_template, Device device)
{
    const H5Reader file(path, model_format, model_version);
    const std::string made_for = file.attribute("template_sha256"), given = body_template.file_sha256;
    require_input(made_for == given, "{}: the model was trained on another template ({}..., not {}...)", path,
                  made_for.substr(0, 12), given.substr(0, 12));
    const auto num_joints = static_cast<std::int64_t>(body_template.skeleton.num_joints());
    const std::vector<std::string> joint_names = file.read_strings("/input/joint_names", num_joints);
    for (std::size_t j = 0; j < joint_names.size(); ++j)
        require_input(joint_names[j] == body_template.skeleton.joint_names[j],
                      "{}: joint {} of the model is \"{}\" where the template's is \"{}\"", path, j, joint_names[j],
                      body_template.skeleton.joint_names[j]);

    NeuralModel model(read_options(file), read_model_shape_space(file, 3 * body_template.num_volume_vertices()),
                      body_template, 0);
    State& state = *model.state_;
    const std::vector<int> visible = file.read_ints("/input/visible_joints", num_joints, 0, 1);
    require_input(visible == state.input_space.visible_joints(),
                  "{}: /input/visible_joints does not fit the template's skinning weights", path);
    state.network = read_network(file, state);
    state.curve = read_curve(file);
    if (file.has_attribute("precision")) state.precision = file.attribute("precision");
    state.device = device;
    state.network.to(device);
    return model;
}

}  // namespace ndg
