// SPDX-License-Identifier: Apache-2.0
// Networks of any size with weights drawn at random, for the runtime: what they cost does not depend on the weights.
#pragma once

#include "ndg/body/template.h"
#include "ndg/core/random.h"
#include "ndg/runtime/export_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

namespace ndg::test {

struct RandomNetwork {
    std::vector<int> widths = {64, 32};
    int num_parts = 1;     ///< the prisms in so many ranges, each with a network that sees part of the pose
    int output_basis = 0;  ///< columns of a fixed basis; 0: none
    double size = 0.1;     ///< of the matrices it gives
    RuntimeWeights weights = {WeightStorage::float32, WeightStorage::float32};
    ModelTraits traits;
};

/// Mean shape: the template body; `dimension` directions at random, of 5 cm.
inline ShapeSpace random_shape_space(const Template& body_template, int dimension)
{
    ShapeSpace space;
    const Points& rest = body_template.rest.volume_vertices;
    space.mean = Eigen::Map<const Eigen::VectorXd>(rest.data(), rest.size());
    space.components.resize(rest.size(), dimension);
    Random random(3, "shape space");
    for (Eigen::Index i = 0; i < space.components.size(); ++i) space.components.data()[i] = random.normal();
    space.components.colwise().normalize();
    space.standard_deviations = Eigen::VectorXd::Constant(dimension, 0.05);
    space.explained_variance = 1;
    return space;
}

inline RuntimeDescription describe_random_network(const Template& body_template, const RandomNetwork& network)
{
    RuntimeDescription model;
    model.traits = network.traits;
    model.template_sha256 = body_template.file_sha256;
    model.joint_names = body_template.skeleton.joint_names;
    model.visible_joints = body_template.visible_joints();
    model.shape_space = random_shape_space(body_template, 10);
    const int num_features = 9 * body_template.skeleton.num_joints() + (network.traits.shape ? 10 : 0);
    for (int p = 0; p < network.num_parts; ++p) {
        RuntimePart& part = model.parts.emplace_back();
        const int count = body_template.num_prisms();
        for (int prism = count * p / network.num_parts; prism < count * (p + 1) / network.num_parts; ++prism)
            part.prisms.push_back(prism);
        part.prisms = fill_groups(std::move(part.prisms));
        for (int input = 0; input < num_features; ++input)
            if (network.num_parts == 1 || (input / 9) % 4 == p % 4 || input % 9 == 0) part.inputs.push_back(input);
        int columns = static_cast<int>(part.inputs.size());
        const auto add_layer = [&](int rows, bool normalised, WeightStorage storage) {
            RuntimeLayer& layer = part.layers.emplace_back();
            layer.num_rows = rows;
            layer.num_columns = columns;
            layer.storage = storage;
            if (normalised) {
                layer.norm_weight.assign(static_cast<std::size_t>(rows), 1.1F);
                layer.norm_bias.assign(static_cast<std::size_t>(rows), 0.1F);
            }
            columns = rows;
        };
        for (const int width : network.widths) add_layer(width, true, network.weights.hidden_layers);
        if (network.output_basis > 0) add_layer(network.output_basis, false, network.weights.hidden_layers);
        add_layer(9 * static_cast<int>(part.prisms.size()), false, network.weights.last_layer);
    }
    return model;
}

/// Uniform weights and biases, the same each time a block is asked for.
inline BlockSource random_blocks(const RuntimeDescription& model, const RandomNetwork& network)
{
    return [&model, size = network.size](int p, int i, int block, float* rows, float* biases) {
        const RuntimeLayer& layer = model.parts[p].layers[i];
        const bool last = i + 1 == static_cast<int>(model.parts[p].layers.size());
        std::uint64_t state = 0x9E3779B97F4A7C15U * std::uint64_t(1 + block + 100000 * i + 10000000 * p);
        const auto uniform = [&state] {  // xorshift
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            return static_cast<float>(static_cast<double>(state >> 11) * 0x1.0p-52 - 1.0);
        };
        const auto scale = static_cast<float>((last ? size : 2.0) / std::sqrt(static_cast<double>(layer.num_columns)));
        const int used = std::min(weight_rows, layer.num_rows - block * weight_rows);
        for (int k = 0; k < used * layer.num_columns; ++k) rows[k] = scale * uniform();
        for (int r = 0; r < used; ++r) biases[r] = (last ? static_cast<float>(size) : 0.3F) * uniform();
    };
}

inline void write_random_network(const std::string& path, const Template& body_template, const RandomNetwork& network)
{
    const RuntimeDescription model = describe_random_network(body_template, network);
    write_runtime_model(path, model, random_blocks(model, network), Provenance{});
}

}  // namespace ndg::test
