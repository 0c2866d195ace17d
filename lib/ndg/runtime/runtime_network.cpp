// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/runtime_network.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

constexpr int entries = 9;             ///< of a prism's matrix: blocks of the last layer a group of prisms
constexpr float norm_epsilon = 1e-5F;  // as torch::layer_norm's
/// Of the last layer that a thread takes at a time, bytes: small enough that threads end together.
constexpr std::size_t chunk_bytes = 1 << 20;
/// Blocks of a hidden layer that a thread takes at a time.
constexpr int chunk_blocks = 8;

float gelu(float x)
{
    return 0.5F * x * (1.0F + std::erf(x * 0.70710678F));
}

/// Layer normalisation (Ba et al. 2016), then GELU (Hendrycks and Gimpel 2016), in place.
void normalise(const RuntimeLayer& layer, std::vector<float>& values)
{
    const auto count = static_cast<std::size_t>(layer.num_rows);
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < count; ++i) sum += static_cast<double>(values[i]);
    const double mean = sum / static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double offset = static_cast<double>(values[i]) - mean;
        squares += offset * offset;
    }
    const auto scale =
        static_cast<float>(1.0 / std::sqrt(squares / static_cast<double>(count) + static_cast<double>(norm_epsilon)));
    for (std::size_t i = 0; i < count; ++i)
        values[i] = gelu((values[i] - static_cast<float>(mean)) * scale * layer.norm_weight[i] + layer.norm_bias[i]);
}

}  // namespace

RuntimeNetwork::RuntimeNetwork(const RuntimeModel& model)
    : model_(model),
      kernels_{&find_weight_kernel(WeightStorage::float32), &find_weight_kernel(WeightStorage::bfloat16),
               &find_weight_kernel(WeightStorage::int8)},
      states_(model.parts.size())
{
    for (std::size_t p = 0; p < model.parts.size(); ++p) {
        const RuntimePart& part = model.parts[p];
        PartState& state = states_[p];
        state.first_group = static_cast<int>(prisms_.size()) / group_prisms;
        prisms_.insert(prisms_.end(), part.prisms.begin(), part.prisms.end());
        std::size_t most_rows = 0;
        for (std::size_t i = 0; i + 1 < part.layers.size(); ++i)
            most_rows =
                std::max(most_rows, static_cast<std::size_t>(num_weight_blocks(part.layers[i].num_rows) * weight_rows));
        state.results.resize(most_rows);
        const std::size_t group_bytes =
            entries * weight_block_bytes(part.layers.back().storage, part.layers.back().num_columns);
        const int groups = std::max(1, static_cast<int>(chunk_bytes / group_bytes));
        for (int begin = 0; begin < part.num_groups(); begin += groups)
            chunks_.push_back({static_cast<int>(p), begin, std::min(begin + groups, part.num_groups())});
    }
    outputs_.resize(entries * prisms_.size());
}

void RuntimeNetwork::multiply(const RuntimeLayer& layer, const PackedVector& input, int begin, int end,
                              float* results) const
{
    const std::size_t block_bytes = weight_block_bytes(layer.storage, layer.num_columns);
    kernel(layer).multiply(input, layer.blocks + block_bytes * static_cast<std::size_t>(begin), end - begin, results);
}

void RuntimeNetwork::set_input(std::size_t part_idx, const Eigen::RowVectorXf& features)
{
    const RuntimePart& part = model_.parts[part_idx];
    std::vector<float> seen(part.inputs.size());
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = features[part.inputs[i]];
    states_[part_idx].input.set(seen.data(), static_cast<int>(seen.size()), part.layers[0].storage);
}

/// Results of a hidden layer become the input of the next one.
void RuntimeNetwork::finish_layer(std::size_t part_idx, std::size_t layer_idx)
{
    const RuntimePart& part = model_.parts[part_idx];
    const RuntimeLayer& layer = part.layers[layer_idx];
    PartState& state = states_[part_idx];
    if (!layer.norm_weight.empty()) normalise(layer, state.results);
    state.input.set(state.results.data(), layer.num_rows, part.layers[layer_idx + 1].storage);
}

void RuntimeNetwork::hidden(const Eigen::RowVectorXf& features)
{
    const auto num_parts = static_cast<int>(model_.parts.size());
    if (num_parts > 1) {  // of many small ones each thread takes whole ones
#pragma omp for schedule(dynamic, 1)
        for (int p = 0; p < num_parts; ++p) {
            const RuntimePart& part = model_.parts[p];
            set_input(static_cast<std::size_t>(p), features);
            for (std::size_t i = 0; i + 1 < part.layers.size(); ++i) {
                multiply(part.layers[i], states_[p].input, 0, num_weight_blocks(part.layers[i].num_rows),
                         states_[p].results.data());
                finish_layer(static_cast<std::size_t>(p), i);
            }
        }
        return;
    }
#pragma omp single
    set_input(0, features);
    const RuntimePart& part = model_.parts[0];
    for (std::size_t i = 0; i + 1 < part.layers.size(); ++i) {
        const int num_blocks = num_weight_blocks(part.layers[i].num_rows);
#pragma omp for schedule(dynamic, 1)
        for (int begin = 0; begin < num_blocks; begin += chunk_blocks)
            multiply(part.layers[i], states_[0].input, begin, std::min(begin + chunk_blocks, num_blocks),
                     states_[0].results.data() + static_cast<std::ptrdiff_t>(weight_rows) * begin);
#pragma omp single
        finish_layer(0, i);
    }
}

void RuntimeNetwork::last()
{
    const auto num_chunks = static_cast<int>(chunks_.size());
#pragma omp for schedule(dynamic, 1)
    for (int c = 0; c < num_chunks; ++c) {
        const Chunk& chunk = chunks_[c];
        const PartState& state = states_[chunk.part];
        multiply(
            model_.parts[chunk.part].layers.back(), state.input, entries * chunk.begin, entries * chunk.end,
            outputs_.data() + static_cast<std::ptrdiff_t>(entries * group_prisms) * (state.first_group + chunk.begin));
    }
}

}  // namespace ndg
