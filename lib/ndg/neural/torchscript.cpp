// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/torchscript.h"

#include "ndg/core/error.h"
#include "ndg/core/stream_file.h"
#include "ndg/io/licences.h"
#include "ndg/neural/archive_stream.h"
#include "ndg/neural/model_state.h"

#include <torch/csrc/jit/api/module.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace ndg {
namespace {

using Json = nlohmann::json;
using torch::Tensor;

/// What the network sees of a pose and a body, as InputSpace::features.
const char* const features_code = R"(
def features(self, parent_from_joint: Tensor, rest_volume: Tensor) -> Tensor:
    turned = (parent_from_joint - torch.eye(3, device=parent_from_joint.device)) * self.visible_joints
    code = torch.matmul(rest_volume.reshape(rest_volume.size(0), -1) - self.shape_mean, self.shape_axes)
    return torch.cat([turned.reshape(turned.size(0), -1), code], 1)
)";

const char* const forward_code = R"(
def forward(self, parent_from_joint: Tensor, rest_volume: Tensor) -> Tensor:
    return self.activate(self.outputs(self.features(parent_from_joint, rest_volume)))
)";

class Script {
public:
    explicit Script(NeuralModel& model) : model_(model.state()), module_("NeuralDeformationGradients")
    {
        add_inputs();
        std::string code = "def outputs(self, features: Tensor) -> Tensor:\n";
        const bool regional = model_.network.parts.front().outputs.defined();
        if (regional)
            code += fmt::format("    y = torch.zeros(features.size(0), {}, device=features.device)\n",
                                model_.network.num_outputs);
        for (std::size_t i = 0; i < model_.network.parts.size(); ++i) code += part_code(i);
        module_.define(code + "    return y\n");
        module_.define(fmt::format("def activate(self, y: Tensor) -> Tensor:\n{}", model_.output_space->script()));
        module_.define(features_code);
        module_.define(forward_code);
    }

    const torch::jit::Module& module() const { return module_; }

private:
    std::string keep(const std::string& name, const Tensor& tensor)
    {
        module_.register_buffer(name, tensor.detach().to(torch::kCPU).contiguous());
        return "self." + name;
    }

    void add_inputs()
    {
        const InputSpace& space = model_.input_space;
        const auto num_joints = static_cast<std::int64_t>(space.visible_joints().size());
        Tensor visible = torch::empty({num_joints, 1, 1});
        for (std::int64_t j = 0; j < num_joints; ++j)
            visible.data_ptr<float>()[j] = static_cast<float>(space.visible_joints()[j]);
        keep("visible_joints", visible);
        const ShapeSpace& shapes = space.shape_space();
        const Eigen::RowVectorXf mean = shapes.mean.cast<float>();
        keep("shape_mean", tensor_from(mean));
        const Eigen::Index used = space.width() - 9 * num_joints;  // none where the network does not see the body
        const RowMatrixF axes = (shapes.components.leftCols(used) / space.code_scale()).cast<float>();
        keep("shape_axes", tensor_from(axes));
    }

    /// Lines that make `y`, or a region's columns of it, of `features`.
    std::string part_code(std::size_t part_idx)
    {
        const Network::Part& part = model_.network.parts[part_idx];
        const std::string prefix = fmt::format("part_{}_", part_idx);
        std::string code = "    x = features\n";
        if (part.inputs.defined())
            code += fmt::format("    x = x.index_select(1, {})\n", keep(prefix + "inputs", part.inputs));
        for (std::size_t i = 0; i < part.perceptron.layers.size(); ++i) {
            const TorchNetwork::Layer& layer = part.perceptron.layers[i];
            const std::string name = fmt::format("{}layer_{}_", prefix, i);
            code += fmt::format("    x = torch.addmm({}, x, {}.t())\n", keep(name + "bias", layer.bias),
                                keep(name + "weight", layer.weight));
            if (!layer.norm_weight.defined()) continue;
            code +=
                fmt::format("    x = torch.gelu(torch.layer_norm(x, [{}], {}, {}))\n", layer.bias.size(0),
                            keep(name + "norm_weight", layer.norm_weight), keep(name + "norm_bias", layer.norm_bias));
        }
        if (part.perceptron.basis.defined())
            code += fmt::format("    x = torch.matmul(x, {})\n", keep(prefix + "basis", part.perceptron.basis));
        if (!part.outputs.defined()) return code + "    y = x\n";
        return code + fmt::format("    y.index_copy_(1, {}, x)\n", keep(prefix + "outputs", part.outputs));
    }

    NeuralModel::State& model_;
    torch::jit::Module module_;
};

std::string metadata(const NeuralModel& model, const NeuralModel::State& state, const Provenance& provenance)
{
    Json inputs = Json::array();
    for (const Provenance::Input& input : provenance.inputs)
        inputs.push_back({{"path", input.path}, {"sha256", input.sha256}});
    const TrainingCurve& curve = model.curve();
    return Json{
        {"method", method_name(model.options())},
        {"template_sha256", state.template_sha256},
        {"joint_names", model.input_space().joint_names()},
        {"num_volume_vertices", model.input_space().num_volume_vertices()},
        {"output_space", model.options().output_space},
        {"parametrisation", to_name(model.options().parametrisation)},
        {"widths", model.options().widths},
        {"bone_wrap", to_name(model.options().posing.bone_wrap)},
        {"best_epoch", curve.best_epoch},
        {"validation_loss",
         curve.best_epoch > 0 ? Json(curve.validation_loss[static_cast<std::size_t>(curve.best_epoch) - 1]) : Json()},
        {"created_by", project_version() + " " + project_commit()},
        {"inputs", inputs},
        {"licences", merged_licences(provenance)}}
        .dump(2);
}

}  // namespace

void write_torchscript(const std::string& path, NeuralModel& model, const Provenance& provenance)
{
    // Into a stream: what is saved under a name holds that name, which is another one every time.
    write_stream(path, [&](std::ostream& stream) {
        try {
            const Script script(model);
            ArchiveBuffer buffer(stream);
            std::ostream archive(&buffer);
            script.module().save(archive, {{"metadata.json", metadata(model, model.state(), provenance)}});
        } catch (const c10::Error& error) {
            throw Error(fmt::format("{}: the TorchScript was not written: {}", path, error.what_without_backtrace()));
        }
    });
}

}  // namespace ndg
