// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch).
#pragma once

#include "ndg/neural/model.h"
#include "ndg/neural/network.h"

namespace ndg {

struct NeuralModel::State {
    NetworkOptions options;
    InputSpace input_space;
    std::shared_ptr<const OutputSpace> output_space;
    std::string template_sha256;
    std::uint64_t seed = 0;
    Device device = Device::cpu;
    std::vector<NetworkColumns> columns;  ///< of the network's parts; empty: one part with all
    Network network;
    TrainingCurve curve;
    std::string precision;  ///< of the products it was trained with; empty: not said

    /// Untrained, the last layers of its parts on `bases`; none: trained last layers.
    Network new_network(const std::vector<RowMatrixF>& bases) const
    {
        return make_network(options.widths, input_space.width(), output_space->width(), columns, bases, seed);
    }
    /// (B, inputs) on the CPU to predictions (B, outputs) on the device.
    torch::Tensor predict(const RowMatrixF& features) const
    {
        return output_space->activate(network.forward(tensor_from(features).to(torch_device(device))));
    }
};

}  // namespace ndg
