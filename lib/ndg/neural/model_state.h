// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch).
#pragma once

#include "ndg/neural/model.h"
#include "ndg/neural/torch_network.h"

namespace ndg {

struct NdgModel::State {
    NetworkOptions options;
    ShapeSpace shape_space;
    Skeleton skeleton;
    SkinningWeights prism_weights;
    std::vector<int> visible;
    std::string template_sha256;
    int num_prisms = 0;
    std::uint64_t seed = 0;
    Device device = Device::cpu;
    TorchNetwork network;
    TrainingCurve curve;

    int num_inputs() const { return 9 * skeleton.num_joints() + (options.shape ? shape_space.dimension() : 0); }
};

}  // namespace ndg
