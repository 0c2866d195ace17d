// SPDX-License-Identifier: Apache-2.0
#include "ndg/release/cards.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/provenance.h"
#include "ndg/info/describe_file.h"
#include "ndg/io/h5.h"
#include "ndg/io/licences.h"
#include "ndg/runtime/model_layout.h"
#include "ndg/runtime/model_traits.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <sstream>

namespace ndg {
namespace {

using Json = nlohmann::ordered_json;

std::string tensor(const std::string& dataset)
{
    std::string name = dataset.substr(1);
    std::replace(name.begin(), name.end(), '/', '.');
    return name;
}

/// Licence lines of these files, each once.
std::string licence_list(const std::vector<std::string>& paths)
{
    Provenance provenance;
    for (const std::string& path : paths) provenance.inputs.push_back({path, "", "", false});
    std::istringstream lines(merged_licences(provenance));
    std::string list;
    for (std::string line; std::getline(lines, line);) list += "- " + line + "\n";
    return list.empty() ? "- none but the project's own, Apache-2.0\n" : list;
}

std::string facts(const std::string& path)
{
    FileQuestion question;
    question.path = path;
    return fmt::format("```\n{}```\n", describe_file(question).rows());
}

const std::string figures_legend = R"(
Against the finite-element simulation, on bodies and poses that training never saw. E_pos: mean distance of the vertices
of muscle wrap and skin, mm. E_grad: mean squared difference of the deformation gradients' entries. E_inv: inverted
prisms a frame. E_corner: prisms a frame with a negative Jacobian at a corner. E_vol: mean squared relative change of the
prisms' volume.

)";

/// Table 1 of tables.json as Markdown.
std::string figures(const std::string& tables_path)
{
    if (tables_path.empty()) return "Not evaluated.\n";
    const Json tables = Json::parse(read_file(tables_path), nullptr, false);
    require_input(tables.is_object() && tables.contains("table1") && !tables["table1"].empty(), "{}: has no table1",
                  tables_path);
    std::string text, head = "| method |", rule = "|---|";
    for (const auto& [measure, value] : tables["table1"].begin()->items()) {
        head += " " + measure + " |";
        rule += "---|";
    }
    for (const auto& [method, row] : tables["table1"].items()) {
        text += "| " + method + " |";
        for (const auto& [measure, value] : row.items()) text += fmt::format(" {:.3f} |", value.get<double>());
        text += "\n";
    }
    const Json counts = tables.value("counts", Json::object());
    std::string data;
    for (const auto& [name, value] : counts.items())
        if (value.is_number()) data += fmt::format("{}{} {}", data.empty() ? "" : ", ", name, value.dump());
    return head + "\n" + rule + "\n" + text + figures_legend + data + "\n";
}

}  // namespace

std::string network_config(const std::string& model_path)
{
    const H5Reader file(model_path, model_format, model_version);
    const ModelTraits traits = read_model_traits(file);
    const ShapeSpace space = read_model_shape_space(file, -1);
    Json parts = Json::array();
    for (const PartLayout& part : read_model_layout(file)) {
        Json layers = Json::array();
        for (const LayerLayout& layer : part.layers)
            layers.push_back({{"tensors", tensor(layer.group)},
                              {"inputs", layer.num_columns},
                              {"outputs", layer.num_rows},
                              {"layer_norm", layer.has_norm},
                              {"activation", layer.has_norm ? Json("gelu") : Json()}});
        parts.push_back({{"inputs", part.region.empty() ? Json() : Json(tensor(part.region + "/inputs"))},
                         {"layers", layers},
                         {"output_basis", part.basis.empty() ? Json() : Json(tensor(part.basis))},
                         {"outputs", part.region.empty() ? Json() : Json(tensor(part.region + "/outputs"))}});
    }
    const auto joint_names = file.read_strings("/input/joint_names");
    return Json{{"architecture", "multilayer perceptrons: out = weight in + bias, layer norm, exact GELU"},
                {"created_by", Json::parse(file.attribute("created_by"))},
                {"output_space", traits.output_space},
                {"parametrisation", to_name(traits.parametrisation)},
                {"rotation", traits.rotation},
                {"sees_shape", traits.shape},
                {"bone_wrap", to_name(traits.posing.bone_wrap)},
                {"layer_norm_epsilon", 1e-5},
                {"units", "m"},
                {"up_axis", "y"},
                {"joint_names", joint_names},
                {"features",
                 {{"pose", "9 numbers a joint, row by row: (parent_from_joint - identity) * input.visible_joints"},
                  {"shape", "(shape_space.components^T (volume vertices at rest - shape_space.mean)) / code_scale"}}},
                {"num_volume_vertices", space.mean.size() / 3},
                {"shape_dimension", space.dimension()},
                {"code_scale", shape_code_scale(space)},
                {"parts", parts},
                {"template_sha256", file.attribute("template_sha256")},
                {"inputs", Json::parse(file.attribute("inputs"))},
                {"licences", file.attribute("licences")}}
               .dump(2) +
           "\n";
}

std::string model_card(const ReleaseInputs& inputs)
{
    const H5Reader file(inputs.model_path, model_format, model_version);
    const ModelTraits traits = read_model_traits(file);
    const bool residuals = traits.output_space == "residuals";
    return fmt::format(
        R"(# Model card: {name}

A network that predicts how the flesh of anatomical bodies deforms, from pose and body shape: {what}.

Method: Nolte, Kemper, Schwanecke and Botsch, *Skeletal-Driven Animation of Anatomical Humans via Neural Deformation Gradients*
(Computer Graphics Forum 2026), as this project implements it.

## Inputs and outputs

Metres, y up; the body faces +z, its left side is +x; at rest every joint's frame is that of the world.

| | shape | |
|---|---|---|
| `parent_from_joint` | batch x J x 3 x 3 | rotations of the pose, relative to rest, joints as in `config.json`; the root's is not used |
| `shape_code` | batch x d | the body: `shape_space.components`^T (volume vertices at rest - `shape_space.mean`), m; once a body |
{output}

## Files

| file | |
|---|---|
| `model.safetensors`, `config.json` | all numbers of the network, as trained, and how they are put together |
| `model.onnx` | the network as a graph of ONNX, opset 17; no constant over 500 MB |
| `model.ndg`, `template.h5`, `bodies.h5` | for `libndg`: weights in 8 bits; template and bodies to pose |
| `dataset-card.md` | what it was trained on |
| `SHA256SUMS` | `sha256sum -c SHA256SUMS` |

## Figures

{figures}
## Training data and licences

`dataset-card.md` describes the data. Licences and credits that travel with the network:

{licences}
The network's own numbers and the project's code: Apache-2.0, as far as the data above asks for nothing more.

## Limits

- It knows bodies in the tessellation of its template alone, and people and poses like those of the training.
- Its truth is a quasi-static simulation: no dynamics, no muscle activation, and contact only where the data says so.
- Head, hands and toes are moved by linear blend skinning. It is no medical device.

## What ndg-info says of it

{facts})",
        fmt::arg("name", inputs.name),
        fmt::arg("what", residuals ? "a residual deformation gradient for every prism between bone and skin"
                                   : "offsets of the vertices of muscle wrap and skin"),
        fmt::arg(
            "output",
            residuals
                ? "| `residuals` | batch x N_p x 3 x 3 | R_p^T F_p of every prism; a Poisson solve turns R_p times it "
                  "into vertices |\n| `outputs` | batch x 9 N_p | the same before the matrix exponential |"
                : "| `offsets` | batch x 2 N_w x 3 | of muscle wrap, then skin, in the rest pose, m |"),
        fmt::arg("figures", figures(inputs.tables_path)), fmt::arg("licences", licence_list({inputs.model_path})),
        fmt::arg("facts", facts(inputs.model_path)));
}

std::string dataset_card(const ReleaseInputs& inputs)
{
    std::string text = fmt::format(R"(# Dataset card: {}

Simulated bodies in poses, on which the network beside this card was trained. The data set itself is not part of the
release; the tools, options and inputs below make it again.

All lengths in metres, y up; the body faces +z, its left side is +x.

## Licences and credits

{}
## Files, in the order of their making

)",
                                   inputs.name, licence_list(inputs.data_paths));
    for (const std::string& path : inputs.data_paths) text += facts(path) + "\n";
    return text + R"(## Limits

- People are drawn from statistics of adults and from the parameters of their source; nobody was scanned.
- Poses are those of the motions named above, and splices of them; contact of flesh with itself is simulated only where
  the options of simulate-fem say so.
- The simulation's material is one of passive tissue at rest, the same for all people.
)";
}

}  // namespace ndg
