// SPDX-License-Identifier: Apache-2.0
#include "ndg/release/onnx_file.h"

#include "ndg/core/error.h"
#include "ndg/core/provenance.h"
#include "ndg/core/stream_file.h"

#include <memory>

namespace ndg {
namespace {

// Numbers of fields in onnx.proto, and of types.
namespace model {
constexpr int ir_version = 1, producer_name = 2, producer_version = 3, doc_string = 6, graph = 7, opset_import = 8,
              metadata_props = 14;
}
namespace graph {
constexpr int node = 1, name = 2, initializer = 5, input = 11, output = 12;
}
namespace node {
constexpr int input = 1, output = 2, name = 3, op_type = 4, attribute = 5;
}
namespace attribute {
constexpr int name = 1, f = 2, i = 3, type = 20;
constexpr int type_float = 1, type_int = 2;
}  // namespace attribute
namespace tensor {
constexpr int dims = 1, data_type = 2, name = 8, raw_data = 9;
constexpr int type_float = 1, type_int64 = 7;
}  // namespace tensor
namespace value {
constexpr int name = 1, type = 2, doc_string = 3;
constexpr int tensor_type = 1, elem_type = 1, shape = 2, dim = 1, dim_value = 1, dim_param = 2;
}  // namespace value
constexpr int ir_version_of_opset = 8;
constexpr std::uint64_t largest_message = (std::uint64_t(1) << 31) - 1;

ProtobufMessage value_info(const std::string& name, const OnnxGraph::Shape& shape, const std::string& description)
{
    ProtobufMessage extents, tensor_type, type, info;
    for (const std::int64_t extent : shape) {
        ProtobufMessage dimension;
        if (extent < 0) {
            dimension.add_text(value::dim_param, "batch");
        } else {
            dimension.add_integer(value::dim_value, extent);
        }
        extents.add(value::dim, dimension);
    }
    tensor_type.add_integer(value::elem_type, tensor::type_float).add(value::shape, extents);
    type.add(value::tensor_type, tensor_type);
    info.add_text(value::name, name).add(value::type, type).add_text(value::doc_string, description);
    return info;
}

template <typename T>
std::function<void(std::ostream&)> writer_of(const std::vector<T>& values)
{
    return [values](std::ostream& stream) {
        stream.write(reinterpret_cast<const char*>(values.data()),
                     static_cast<std::streamsize>(sizeof(T) * values.size()));
    };
}

}  // namespace

void OnnxGraph::add_input(const std::string& name, const Shape& shape, const std::string& description)
{
    graph_.add(graph::input, value_info(name, shape, description));
}

void OnnxGraph::add_output(const std::string& name, const Shape& shape, const std::string& description)
{
    graph_.add(graph::output, value_info(name, shape, description));
}

std::string OnnxGraph::add(const std::string& op, const std::vector<std::string>& inputs,
                           const std::vector<Attribute>& attributes, const std::string& result)
{
    ProtobufMessage message;
    const std::string name = fmt::format("{}_{}", op, num_nodes_++);
    for (const std::string& input : inputs) message.add_text(node::input, input);
    const std::string output = result.empty() ? name : result;
    message.add_text(node::output, output).add_text(node::name, name).add_text(node::op_type, op);
    for (const Attribute& given : attributes) {
        ProtobufMessage field;
        field.add_text(attribute::name, given.name);
        if (given.is_real) {
            field.add_float(attribute::f, given.real).add_integer(attribute::type, attribute::type_float);
        } else {
            field.add_integer(attribute::i, given.integer).add_integer(attribute::type, attribute::type_int);
        }
        message.add(node::attribute, field);
    }
    graph_.add(graph::node, message);
    return output;
}

void OnnxGraph::add_constant(const std::string& name, const Shape& shape, int type, std::uint64_t num_bytes,
                             std::function<void(std::ostream&)> write)
{
    Constant constant;
    for (const std::int64_t extent : shape) constant.head.add_integer(tensor::dims, extent);
    constant.head.add_integer(tensor::data_type, type).add_text(tensor::name, name).begin(tensor::raw_data, num_bytes);
    constant.num_bytes = num_bytes;
    constant.write = std::move(write);
    constants_.push_back(std::move(constant));
}

std::string OnnxGraph::add_constant(const std::string& name, const Shape& shape,
                                    std::function<void(std::ostream&)> write)
{
    std::uint64_t num_bytes = sizeof(float);
    for (const std::int64_t extent : shape) num_bytes *= static_cast<std::uint64_t>(extent);
    add_constant(name, shape, tensor::type_float, num_bytes, std::move(write));
    return name;
}

std::string OnnxGraph::add_constant(const std::string& name, const Shape& shape, const std::vector<float>& values)
{
    return add_constant(name, shape, writer_of(values));
}

std::string OnnxGraph::add_constant(const std::string& name, const std::vector<std::int64_t>& values)
{
    add_constant(name, {static_cast<std::int64_t>(values.size())}, tensor::type_int64, 8 * values.size(),
                 writer_of(values));
    return name;
}

void OnnxGraph::write(const std::string& path, const std::string& description,
                      const std::vector<std::pair<std::string, std::string>>& properties) const
{
    ProtobufMessage head, opset, graph_head = graph_;
    graph_head.add_text(graph::name, "neural_deformation_gradients");
    std::uint64_t graph_bytes = graph_head.bytes().size();
    std::vector<std::string> constant_heads;
    for (const Constant& constant : constants_) {
        ProtobufMessage field;
        field.begin(graph::initializer, constant.head.bytes().size() + constant.num_bytes);
        constant_heads.push_back(field.bytes() + constant.head.bytes());
        graph_bytes += constant_heads.back().size() + constant.num_bytes;
    }
    opset.add_text(1, "").add_integer(2, onnx_opset);  // domain: ONNX's own; version
    head.add_integer(model::ir_version, ir_version_of_opset)
        .add_text(model::producer_name, "neural-deformation-gradients")
        .add_text(model::producer_version, project_version() + " " + project_commit())
        .add_text(model::doc_string, description)
        .add(model::opset_import, opset);
    for (const auto& [name, text] : properties) {
        ProtobufMessage property;
        head.add(model::metadata_props, property.add_text(1, name).add_text(2, text));
    }
    head.begin(model::graph, graph_bytes);
    require(head.bytes().size() + graph_bytes <= largest_message,
            "{}: the network has {} MB, files of ONNX can have 2 147", path, graph_bytes / 1000000);

    write_stream(path, [&](std::ostream& stream) {
        stream << head.bytes() << graph_head.bytes();
        for (std::size_t i = 0; i < constants_.size(); ++i) {
            stream << constant_heads[i];
            const std::streampos begin = stream.tellp();
            constants_[i].write(stream);
            require(!stream.fail(), "{}: could not be written", path);
            require(static_cast<std::uint64_t>(stream.tellp() - begin) == constants_[i].num_bytes,
                    "{}: a constant has another size than was announced", path);
        }
    });
}

}  // namespace ndg
