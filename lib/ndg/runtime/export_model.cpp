// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/export_model.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/runtime/model_layout.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ndg {
namespace {

constexpr int entries = 9;  ///< of a prism's matrix

/// Where a part's tensors stand in a model file, and what is kept of them while blocks are made.
struct PartSource {
    std::vector<std::string> layers;  ///< "/network/layer_0"
    std::string basis;                ///< dataset; empty: none
    std::vector<std::vector<double>> biases;
    RowMatrixF basis_rows;     ///< coefficients x outputs
    std::vector<float> group;  ///< rows of the last layer of one group of prisms
    std::vector<float> row(const H5Reader& file, std::size_t layer, int index) const
    {
        return file.read_slice(layers[layer] + "/weight", static_cast<std::size_t>(index));
    }
};

std::vector<float> read_floats(const H5Reader& file, const std::string& name, std::int64_t count)
{
    const std::vector<double> values = file.read_doubles(name, count);
    return {values.begin(), values.end()};
}

/// Prisms whose nine numbers a region's outputs are.
std::vector<int> prisms_of(const H5Reader& file, const std::string& group)
{
    const std::vector<int> outputs = file.read_ints(group + "/outputs", -1, 0, 1 << 30);
    std::vector<int> prisms;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        require_input(outputs.size() % entries == 0 && outputs[i] == outputs[i - i % entries] + int(i % entries) &&
                          outputs[i - i % entries] % entries == 0,
                      "{}: {}/outputs are not whole prisms", file.path(), group);
        if (i % entries == 0) prisms.push_back(outputs[i] / entries);
    }
    return prisms;
}

/// Shapes and vectors of one part.
void read_part(const H5Reader& file, const PartLayout& layout, const RuntimeWeights& weights, RuntimePart& part,
               PartSource& source)
{
    for (const LayerLayout& stored : layout.layers) {
        RuntimeLayer layer;
        layer.num_rows = stored.num_rows;
        layer.num_columns = stored.num_columns;
        layer.storage = weights.hidden_layers;
        if (stored.has_norm) {
            layer.norm_weight = read_floats(file, stored.group + "/norm_weight", layer.num_rows);
            layer.norm_bias = read_floats(file, stored.group + "/norm_bias", layer.num_rows);
        }
        source.layers.push_back(stored.group);
        source.biases.push_back(file.read_doubles(stored.group + "/bias", layer.num_rows));
        part.layers.push_back(std::move(layer));
    }
    if (!layout.basis.empty()) {
        source.basis = layout.basis;
        source.basis_rows.resize(part.layers.back().num_rows, layout.num_outputs);
        for (Eigen::Index k = 0; k < source.basis_rows.rows(); ++k) {
            const std::vector<float> row = file.read_slice(source.basis, static_cast<std::size_t>(k));
            std::copy(row.begin(), row.end(), source.basis_rows.row(k).data());
        }
        RuntimeLayer layer;
        layer.num_rows = layout.num_outputs;
        layer.num_columns = static_cast<int>(source.basis_rows.rows());
        part.layers.push_back(layer);
    }
    part.layers.back().storage = weights.last_layer;
    int& num_outputs = part.layers.back().num_rows;
    std::vector<int> prisms(static_cast<std::size_t>(num_outputs / entries));
    std::iota(prisms.begin(), prisms.end(), 0);
    part.inputs.resize(static_cast<std::size_t>(layout.num_inputs()));
    std::iota(part.inputs.begin(), part.inputs.end(), 0);
    if (!layout.region.empty()) {
        prisms = prisms_of(file, layout.region);
        part.inputs = file.read_ints(layout.region + "/inputs", layout.num_inputs(), 0, 1 << 30);
    }
    require_input(num_outputs == entries * static_cast<int>(prisms.size()), "{}: {} outputs where {} prisms have {}",
                  file.path(), num_outputs, prisms.size(), entries * prisms.size());
    part.prisms = fill_groups(std::move(prisms));
    num_outputs = entries * static_cast<int>(part.prisms.size());
}

/// Rows of a hidden layer.
void copy_block(const H5Reader& file, const RuntimePart& part, const PartSource& source, std::size_t layer, int block,
                float* rows, float* biases)
{
    const int first = block * weight_rows, columns = part.layers[layer].num_columns;
    for (int r = 0; r < std::min(weight_rows, part.layers[layer].num_rows - first); ++r) {
        const std::vector<float> row = source.row(file, layer, first + r);
        std::copy(row.begin(), row.end(), rows + static_cast<std::ptrdiff_t>(r) * columns);
        biases[r] = static_cast<float>(source.biases[layer][first + r]);
    }
}

/// Rows of the last layer: one entry of the matrices of a group of prisms.
void copy_entry_block(const H5Reader& file, const RuntimePart& part, PartSource& source, int block, float* rows,
                      float* biases)
{
    const std::size_t last = part.layers.size() - 1;
    const int columns = part.layers[last].num_columns, first_prism = block / entries * group_prisms;
    const int entry = block % entries;
    const auto used = [&](int lane) { return part.prisms[first_prism + lane] >= 0; };
    if (source.basis.empty() && entry == 0) {  // the rows of a group lie beside each other: each is read once
        source.group.assign(static_cast<std::size_t>(entries * group_prisms * columns), 0.0F);
        for (int i = 0; i < entries * group_prisms; ++i) {
            if (!used(i / entries)) continue;
            const std::vector<float> row = source.row(file, last, entries * first_prism + i);
            std::copy(row.begin(), row.end(), source.group.begin() + static_cast<std::ptrdiff_t>(i) * columns);
        }
    }
    for (int lane = 0; lane < weight_rows; ++lane) {
        if (!used(lane)) continue;
        const int output = entries * (first_prism + lane) + entry;
        float* const row = rows + static_cast<std::ptrdiff_t>(lane) * columns;
        if (source.basis.empty()) {
            std::copy_n(source.group.begin() + static_cast<std::ptrdiff_t>(entries * lane + entry) * columns, columns,
                        row);
            biases[lane] = static_cast<float>(source.biases[last][output]);
        } else {
            for (int k = 0; k < columns; ++k) row[k] = source.basis_rows(k, output);
        }
    }
}

}  // namespace

void describe(OptionList& list, RuntimeWeights& options)
{
    list.add("last-layer", options.last_layer, "how the weights of the last layer, or of the fixed basis, are kept");
    list.add("hidden-layers", options.hidden_layers, "how the other weights are kept");
}

std::vector<int> fill_groups(std::vector<int> prisms)
{
    while (prisms.size() % group_prisms != 0) prisms.push_back(-1);
    return prisms;
}

void export_runtime_model(const std::string& model_path, const RuntimeWeights& weights, const std::string& output_path,
                          const Provenance& provenance)
{
    const H5Reader file(model_path, model_format, model_version);
    RuntimeDescription model;
    model.traits = read_model_traits(file);
    require_input(model.traits.output_space == "residuals",
                  "{}: predicts {}; the runtime knows networks that predict residuals", model_path,
                  model.traits.output_space);
    require_input(model.traits.parametrisation == ParametrisationKind::exponential ||
                      model.traits.parametrisation == ParametrisationKind::direct,
                  "{}: has the parametrisation {}; the runtime knows exponential and direct", model_path,
                  to_name(model.traits.parametrisation));
    model.template_sha256 = file.attribute("template_sha256");
    model.joint_names = file.read_strings("/input/joint_names");
    model.visible_joints =
        file.read_ints("/input/visible_joints", static_cast<std::int64_t>(model.joint_names.size()), 0, 1);
    model.shape_space = read_model_shape_space(file, -1);
    std::vector<PartSource> sources;
    for (const PartLayout& layout : read_model_layout(file))
        read_part(file, layout, weights, model.parts.emplace_back(), sources.emplace_back());
    try {
        model.check();
    } catch (const Error& error) {
        throw InputError(fmt::format("{}: {}", model_path, error.what()));
    }
    write_runtime_model(
        output_path, model,
        [&](int p, int layer, int block, float* rows, float* biases) {
            const RuntimePart& part = model.parts[p];
            if (layer + 1 < static_cast<int>(part.layers.size())) {
                copy_block(file, part, sources[p], static_cast<std::size_t>(layer), block, rows, biases);
            } else {
                copy_entry_block(file, part, sources[p], block, rows, biases);
            }
        },
        provenance);
}

}  // namespace ndg
