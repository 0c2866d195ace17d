// SPDX-License-Identifier: Apache-2.0
// The wire format of protocol buffers (protobuf.dev, "Encoding"), as far as ONNX needs it: messages are lists of
// fields, each a number and a value, in any order.
#pragma once

#include <cstdint>
#include <string>

namespace ndg {

class ProtobufMessage {
public:
    ProtobufMessage& add_integer(int field, std::int64_t value);
    ProtobufMessage& add_float(int field, float value);
    ProtobufMessage& add_text(int field, const std::string& text);
    ProtobufMessage& add(int field, const ProtobufMessage& message) { return add_text(field, message.bytes_); }
    /// Only the beginning of a field of `size` bytes, which the caller writes behind this message.
    ProtobufMessage& begin(int field, std::uint64_t size);

    const std::string& bytes() const { return bytes_; }

private:
    void add_varint(std::uint64_t value);
    std::string bytes_;
};

}  // namespace ndg
