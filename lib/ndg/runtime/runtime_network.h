// SPDX-License-Identifier: Apache-2.0
// The network of the runtime: one frame at a time, both cores, the weights read once.
#pragma once

#include "ndg/core/types.h"
#include "ndg/runtime/runtime_model.h"

#include <array>
#include <vector>

namespace ndg {

class RuntimeNetwork {
public:
    /// Keeps a reference to `model`. Takes the fastest kernels.
    explicit RuntimeNetwork(const RuntimeModel& model);

    /// For comparisons: another kernel for the products with weights of its storage.
    void use(const WeightKernel& kernel) { kernels_[static_cast<std::size_t>(kernel.storage)] = &kernel; }

    /// Both are called by all threads of an OpenMP parallel region, or outside of one. First all layers but the last.
    void hidden(const Eigen::RowVectorXf& features);
    /// Then the last layer; at its end outputs() holds.
    void last();

    /// Raw outputs: of each group of prisms, part after part, a matrix_lanes::Block<float>.
    const std::vector<float>& outputs() const { return outputs_; }
    /// Prism of each lane of outputs(), or -1.
    const std::vector<int>& prisms() const { return prisms_; }

private:
    struct PartState {
        PackedVector input;          ///< of the layer that comes next
        std::vector<float> results;  ///< of a hidden layer
        int first_group = 0;         ///< in outputs_
    };
    /// Some groups of one part: what a thread takes at a time.
    struct Chunk {
        int part = 0, begin = 0, end = 0;
    };

    const WeightKernel& kernel(const RuntimeLayer& layer) const
    {
        return *kernels_[static_cast<std::size_t>(layer.storage)];
    }
    void multiply(const RuntimeLayer& layer, const PackedVector& input, int begin, int end, float* results) const;
    void set_input(std::size_t part, const Eigen::RowVectorXf& features);
    void finish_layer(std::size_t part, std::size_t layer);

    const RuntimeModel& model_;
    std::array<const WeightKernel*, 3> kernels_;
    std::vector<PartState> states_;
    std::vector<Chunk> chunks_;
    std::vector<float> outputs_;
    std::vector<int> prisms_;
};

}  // namespace ndg
