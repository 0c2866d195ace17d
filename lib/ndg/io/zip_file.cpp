// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/zip_file.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <zlib.h>

#include <string_view>

namespace ndg {
namespace {

constexpr std::size_t end_record_size = 22, central_size = 46, local_size = 30, longest_comment = 65535;
constexpr std::uint32_t end_signature = 0x06054b50, central_signature = 0x02014b50, local_signature = 0x04034b50;
/// Deflate packs at most 1032 to 1; a larger announced size is a lie.
constexpr std::size_t largest_ratio = 1032;

/// Start of the record that ends a zip file, npos where there is none.
std::size_t find_end_record(std::string_view bytes)
{
    if (bytes.size() < end_record_size) return std::string_view::npos;
    const std::size_t last = bytes.size() - end_record_size;
    const std::size_t first = last > longest_comment ? last - longest_comment : 0;
    for (std::size_t at = last + 1; at-- > first;) {
        if (number_at(bytes, at, 4) == end_signature &&
            at + end_record_size + number_at(bytes, at + 20, 2) == bytes.size())
            return at;
    }
    return std::string_view::npos;
}

/// Raw deflate, as zip entries hold it; false where the stream is broken or gives another size.
bool inflate_raw(std::string_view packed, std::string& unpacked)
{
    z_stream stream = {};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return false;
    // Sizes of zip entries have 32 bits, as zlib's do.
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
    stream.avail_out = static_cast<uInt>(unpacked.size());
    const int result = inflate(&stream, Z_FINISH);
    const bool complete = result == Z_STREAM_END && stream.total_out == unpacked.size();
    inflateEnd(&stream);
    return complete;
}

}  // namespace

std::uint32_t number_at(std::string_view bytes, std::size_t at, int num_bytes)
{
    std::uint32_t value = 0;
    for (int b = num_bytes - 1; b >= 0; --b) value = (value << 8) | static_cast<unsigned char>(bytes[at + b]);
    return value;
}

ZipFile::ZipFile(const std::string& path) : path_(path), bytes_(read_file(path))
{
    const std::string_view bytes = bytes_;
    const std::size_t end = find_end_record(bytes);
    require_input(end != std::string_view::npos, "{}: is no zip archive or is truncated ({} bytes)", path,
                  bytes.size());
    const std::size_t count = number_at(bytes, end + 10, 2);
    const std::size_t size = number_at(bytes, end + 12, 4), start = number_at(bytes, end + 16, 4);
    require_input(start != 0xffffffffU && count != 0xffffU, "{}: is a zip archive larger than 4 GiB", path);
    require_input(start <= end && size <= end - start, "{}: its zip directory lies outside the file at byte {}", path,
                  start);
    std::size_t at = start;
    for (std::size_t e = 0; e < count; ++e) {
        require_input(end - at >= central_size && number_at(bytes, at, 4) == central_signature,
                      "{}: entry {} of its zip directory is broken", path, e);
        const std::size_t name_size = number_at(bytes, at + 28, 2);
        const std::size_t rest = name_size + number_at(bytes, at + 30, 2) + number_at(bytes, at + 32, 2);
        require_input(end - at - central_size >= rest, "{}: entry {} of its zip directory is broken", path, e);
        const std::string name(bytes.substr(at + central_size, name_size));
        Entry entry;
        entry.method = number_at(bytes, at + 10, 2);
        entry.checksum = number_at(bytes, at + 16, 4);
        entry.packed_size = number_at(bytes, at + 20, 4);
        entry.size = number_at(bytes, at + 24, 4);
        entry.header = number_at(bytes, at + 42, 4);
        require_input((number_at(bytes, at + 8, 2) & 1U) == 0, "{}: {} is encrypted", path, name);
        at += central_size + rest;
        require_input(entries_.emplace(name, entry).second, "{}: holds \"{}\" twice", path, name);
    }
}

std::string ZipFile::unpack(const std::string& name, const std::string& item) const
{
    const std::string_view bytes = bytes_;
    const auto found = entries_.find(name);
    require_input(found != entries_.end(), "{}: holds no \"{}\"", path_, name);
    const Entry& entry = found->second;
    require_input(entry.header < bytes.size() && bytes.size() - entry.header >= local_size &&
                      number_at(bytes, entry.header, 4) == local_signature,
                  "{}: there is no zip entry at byte {}", item, entry.header);
    // Name and extra fields of the local header have lengths of their own.
    const std::size_t start =
        entry.header + local_size + number_at(bytes, entry.header + 26, 2) + number_at(bytes, entry.header + 28, 2);
    require_input(start <= bytes.size() && entry.packed_size <= bytes.size() - start,
                  "{}: has {} packed bytes, which reach past the end of the file", item, entry.packed_size);
    const std::string_view packed = bytes.substr(start, entry.packed_size);
    require_input(entry.method == 0 || entry.method == 8, "{}: is packed by zip method {}, not stored or deflated",
                  item, entry.method);
    std::string unpacked;
    if (entry.method == 0) {
        require_input(entry.size == entry.packed_size, "{}: has {} bytes stored as {}", item, entry.size,
                      entry.packed_size);
        unpacked = packed;
    } else {
        require_input(entry.size / largest_ratio <= entry.packed_size,
                      "{}: {} packed bytes cannot hold the {} it announces", item, entry.packed_size, entry.size);
        unpacked.resize(entry.size);
        require_input(inflate_raw(packed, unpacked), "{}: its {} packed bytes cannot be unpacked", item,
                      entry.packed_size);
    }
    const auto checksum =
        static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(unpacked.data()), unpacked.size()));
    require_input(checksum == entry.checksum, "{}: its checksum is {:08x}, not {:08x}", item, checksum, entry.checksum);
    return unpacked;
}

}  // namespace ndg
