// SPDX-License-Identifier: Apache-2.0
// Where the tensors of a trained network stand in its file, for those that read them one by one.
#pragma once

#include <string>
#include <vector>

namespace ndg {

class H5Reader;

/// out = weight in + bias; where it has_norm, LayerNorm and GELU follow.
struct LayerLayout {
    std::string group;  ///< "/network/layer_0": of weight, bias, norm_weight, norm_bias
    int num_rows = 0, num_columns = 0;
    bool has_norm = false;
};

/// One perceptron: all of the network, or that of a region of the body.
struct PartLayout {
    std::vector<LayerLayout> layers;
    std::string basis;   ///< dataset (coefficients x outputs) behind the last layer; empty: none
    std::string region;  ///< "/network/region_0": of the columns `inputs` and `outputs`; empty: all of them
    int num_outputs = 0;

    int num_inputs() const { return layers.front().num_columns; }
};

/// Of a file of format "ndg-model". Throws InputError naming file and dataset where there are no layers, something is
/// no matrix, or layers do not fit each other.
std::vector<PartLayout> read_model_layout(const H5Reader& file);

}  // namespace ndg
