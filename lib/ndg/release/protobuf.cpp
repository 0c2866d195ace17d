// SPDX-License-Identifier: Apache-2.0
#include "ndg/release/protobuf.h"

#include <cstring>

namespace ndg {
namespace {

/// How a value is stored; stands in the last three bits of a field's number.
enum WireType { varint = 0, length_delimited = 2, four_bytes = 5 };

std::uint64_t tag(int field, WireType type)
{
    return (static_cast<std::uint64_t>(field) << 3) | type;
}

}  // namespace

void ProtobufMessage::add_varint(std::uint64_t value)
{
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>(value | 0x80);
    bytes_ += static_cast<char>(value);
}

ProtobufMessage& ProtobufMessage::add_integer(int field, std::int64_t value)
{
    add_varint(tag(field, varint));
    add_varint(static_cast<std::uint64_t>(value));
    return *this;
}

ProtobufMessage& ProtobufMessage::add_float(int field, float value)
{
    add_varint(tag(field, four_bytes));
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    bytes_.append(bytes, sizeof value);
    return *this;
}

ProtobufMessage& ProtobufMessage::add_text(int field, const std::string& text)
{
    begin(field, text.size());
    bytes_ += text;
    return *this;
}

ProtobufMessage& ProtobufMessage::begin(int field, std::uint64_t size)
{
    add_varint(tag(field, length_delimited));
    add_varint(size);
    return *this;
}

}  // namespace ndg
