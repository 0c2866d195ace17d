// SPDX-License-Identifier: Apache-2.0
// Files of ONNX (github.com/onnx/onnx, onnx.proto): a graph of operators and the constants they take.
#pragma once

#include "ndg/release/protobuf.h"

#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace ndg {

/// Operators are those of this version of ONNX's own set: the first with LayerNormalization.
constexpr int onnx_opset = 17;

class OnnxGraph {
public:
    /// Extents along the axes; a batch of any size is -1.
    using Shape = std::vector<std::int64_t>;
    struct Attribute {
        std::string name;
        std::int64_t integer = 0;
        float real = 0;
        bool is_real = false;
    };

    void add_input(const std::string& name, const Shape& shape, const std::string& description);
    void add_output(const std::string& name, const Shape& shape, const std::string& description);
    /// Names the result like the operator's first use: "Gemm_3". Returns it.
    std::string add(const std::string& op, const std::vector<std::string>& inputs,
                    const std::vector<Attribute>& attributes = {}, const std::string& result = "");
    /// Constants; float32 and int64. Return `name`.
    std::string add_constant(const std::string& name, const Shape& shape, const std::vector<float>& values);
    std::string add_constant(const std::string& name, const std::vector<std::int64_t>& values);
    /// The same for float32 that `write` writes when the file is written.
    std::string add_constant(const std::string& name, const Shape& shape, std::function<void(std::ostream&)> write);

    /// `properties`: name and text each. Throws Error for a file over 2 GB, which protocol buffers do not allow, and
    /// where it cannot be written.
    void write(const std::string& path, const std::string& description,
               const std::vector<std::pair<std::string, std::string>>& properties) const;

private:
    struct Constant {
        ProtobufMessage head;  ///< all but the numbers
        std::uint64_t num_bytes = 0;
        std::function<void(std::ostream&)> write;
    };
    void add_constant(const std::string& name, const Shape& shape, int type, std::uint64_t num_bytes,
                      std::function<void(std::ostream&)> write);

    ProtobufMessage graph_;  ///< all but the constants
    std::vector<Constant> constants_;
    int num_nodes_ = 0;
};

}  // namespace ndg
