// SPDX-License-Identifier: Apache-2.0
// A network as the runtime uses it: one file, format "ndg-runtime" (docs/formats.md), mapped into memory as it is, so
// that nothing is read at the start but its head.
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/runtime/model_traits.h"
#include "ndg/runtime/weight_matrix.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// Prisms whose matrices lie side by side, one a lane; matrix_lanes::Block<float>::lanes.
constexpr int group_prisms = 16;

struct RuntimeLayer {
    int num_rows = 0, num_columns = 0;
    WeightStorage storage = WeightStorage::float32;
    std::vector<float> norm_weight, norm_bias;  ///< layer normalisation and GELU follow; empty: neither
    std::uint64_t offset = 0;                   ///< of its blocks in the file
    const std::byte* blocks = nullptr;          ///< in the mapping; null in a description to be written
};

/// One perceptron: all of the network, or that of a region of the body. The rows of the last layer are ordered so that
/// its results are matrix_lanes blocks: of each group of group_prisms prisms first entry (0, 0) of all, then (0, 1)...
struct RuntimePart {
    std::vector<int> inputs;  ///< columns of the features that it sees
    std::vector<int> prisms;  ///< whose nine numbers it gives, a multiple of group_prisms; -1: a lane that is not used
    std::vector<RuntimeLayer> layers;

    int num_groups() const { return static_cast<int>(prisms.size()) / group_prisms; }
};

/// All of a model but the weights.
struct RuntimeDescription {
    ModelTraits traits;
    std::string template_sha256;
    std::vector<std::string> joint_names;
    std::vector<int> visible_joints;
    ShapeSpace shape_space;
    std::vector<RuntimePart> parts;

    /// Throws Error (message without a file's name) for layers that do not fit each other, or prisms that are not each
    /// given once.
    void check() const;
    int num_prisms() const;
};

class RuntimeModel : public RuntimeDescription {
public:
    /// Maps a file. Throws InputError naming it and what is wrong: another format or version, too short, inconsistent.
    explicit RuntimeModel(const std::string& path);

    const std::string& path() const { return path_; }
    /// JSON at the beginning of the file: beside the description created_by, config, inputs and licences.
    const std::string& head() const { return head_; }
    /// Throws InputError naming the first layer with a number that is not finite. Reads the whole file.
    void check_weights() const;
    std::size_t weight_bytes() const;
    std::int64_t num_weights() const;

private:
    std::string path_, head_;
    std::shared_ptr<const std::byte> mapping_;
};

/// Writes `weight_rows` rows (weight_rows x columns, row-major, zero before) and biases of block `block` of a layer;
/// asked for in ascending order.
using BlockSource = std::function<void(int part, int layer, int block, float* rows, float* biases)>;
void write_runtime_model(const std::string& path, const RuntimeDescription& model, const BlockSource& source,
                         const Provenance& provenance);

}  // namespace ndg
