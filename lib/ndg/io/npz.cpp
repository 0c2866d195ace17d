// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/npz.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <zlib.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

namespace ndg {

namespace {

constexpr std::size_t end_record_size = 22, central_size = 46, local_size = 30, longest_comment = 65535;
constexpr std::uint32_t end_signature = 0x06054b50, central_signature = 0x02014b50, local_signature = 0x04034b50;
/// Deflate packs at most 1032 to 1; a larger announced size is a lie.
constexpr std::size_t largest_ratio = 1032;

std::uint32_t number_at(std::string_view bytes, std::size_t at, int num_bytes)
{
    std::uint32_t value = 0;
    for (int b = num_bytes - 1; b >= 0; --b) value = (value << 8) | static_cast<unsigned char>(bytes[at + b]);
    return value;
}

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

/// The header of a .npy file: {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }.
class NpyHeader {
public:
    NpyHeader(std::string_view text, std::string item) : text_(text), item_(std::move(item)) {}

    std::string type;
    std::vector<std::int64_t> shape;

    void parse()
    {
        bool has_order = false, has_shape = false;
        expect('{');
        while (!accept('}')) {
            const std::string key = quoted();
            expect(':');
            if (key == "descr") {
                require_input(peek() != '[', "{}: holds records, not numbers", item_);
                type = quoted();
            } else if (key == "fortran_order") {
                has_order = true;
                require_input(!accept_word("True"), "{}: is stored in Fortran order, C order is needed", item_);
                if (!accept_word("False")) fail();
            } else if (key == "shape") {
                has_shape = true;
                parse_shape();
            } else {
                fail();
            }
            if (!accept(',') && peek() != '}') fail();
        }
        if (peek() != '\0' || type.empty() || !has_order || !has_shape) fail();
    }

private:
    [[noreturn]] void fail() const
    {
        throw InputError(fmt::format("{}: its array header breaks off or is malformed at character {}", item_, at_));
    }
    char peek()
    {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool accept(char c)
    {
        if (peek() != c) return false;
        ++at_;
        return true;
    }
    void expect(char c)
    {
        if (!accept(c)) fail();
    }
    bool accept_word(std::string_view word)
    {
        peek();
        if (text_.substr(at_, word.size()) != word) return false;
        at_ += word.size();
        return true;
    }
    std::string quoted()
    {
        expect('\'');
        const std::size_t end = text_.find('\'', at_);
        if (end == std::string_view::npos) fail();
        const std::string word(text_.substr(at_, end - at_));
        at_ = end + 1;
        return word;
    }
    void parse_shape()
    {
        shape.clear();
        expect('(');
        while (!accept(')')) {
            peek();
            std::int64_t count = 0;
            const char* end = text_.data() + text_.size();
            const auto [stop, error] = std::from_chars(text_.data() + at_, end, count);
            if (error != std::errc() || count < 0) fail();
            at_ = static_cast<std::size_t>(stop - text_.data());
            shape.push_back(count);
            if (!accept(',') && peek() != ')') fail();
        }
    }

    std::string_view text_;
    std::string item_;
    std::size_t at_ = 0;
};

template <typename Number>
void copy_numbers(std::string_view bytes, std::vector<double>& values)
{
    for (std::size_t i = 0; i < values.size(); ++i) {
        Number number;
        std::memcpy(&number, bytes.data() + i * sizeof(Number), sizeof(Number));
        values[i] = static_cast<double>(number);
    }
}

using Copy = void (*)(std::string_view, std::vector<double>&);

/// How numbers of a type are read, or nullptr.
Copy find_copy(std::string_view type)
{
    if (type == "<f4") return copy_numbers<float>;
    if (type == "<f8") return copy_numbers<double>;
    if (type == "|i1") return copy_numbers<std::int8_t>;
    if (type == "|u1") return copy_numbers<std::uint8_t>;
    if (type == "<i2") return copy_numbers<std::int16_t>;
    if (type == "<u2") return copy_numbers<std::uint16_t>;
    if (type == "<i4") return copy_numbers<std::int32_t>;
    if (type == "<u4") return copy_numbers<std::uint32_t>;
    if (type == "<i8") return copy_numbers<std::int64_t>;
    if (type == "<u8") return copy_numbers<std::uint64_t>;
    return nullptr;
}

NpyArray parse_npy(std::string_view bytes, const std::string& item)
{
    constexpr std::string_view magic = "\x93NUMPY";
    require_input(bytes.size() >= 10 && bytes.substr(0, magic.size()) == magic, "{}: is no .npy array", item);
    const int version = static_cast<unsigned char>(bytes[6]);
    require_input((version == 1 || version == 2) && bytes[7] == 0, "{}: is a .npy array of version {}, not 1 or 2",
                  item, version);
    const std::size_t prefix = version == 1 ? 10 : 12;
    require_input(bytes.size() >= prefix, "{}: is no .npy array", item);
    const std::size_t header_size = number_at(bytes, 8, version == 1 ? 2 : 4);
    require_input(header_size <= bytes.size() - prefix, "{}: its array header has {} bytes, {} are there", item,
                  header_size, bytes.size() - prefix);
    NpyHeader header(bytes.substr(prefix, header_size), item);
    header.parse();

    require_input(header.type.find('O') == std::string::npos, "{}: is an array of pickled Python objects, not numbers",
                  item);
    const Copy copy = find_copy(header.type);
    require_input(copy != nullptr, "{}: has the type '{}', not float32, float64 or integers (little-endian)", item,
                  header.type);
    const std::size_t number_size = static_cast<std::size_t>(header.type[2] - '0');
    const std::string_view data = bytes.substr(prefix + header_size);
    std::size_t count = 1;
    for (const std::int64_t extent : header.shape) {
        const auto length = static_cast<std::size_t>(extent);
        require_input(length == 0 || count <= std::numeric_limits<std::size_t>::max() / 8 / length,
                      "{}: its shape is too large", item);
        count *= length;
    }
    require_input(count * number_size == data.size(), "{}: has {} bytes of numbers, its shape needs {}", item,
                  data.size(), count * number_size);
    NpyArray array;
    array.shape = header.shape;
    array.values.resize(count);
    copy(data, array.values);
    for (std::size_t i = 0; i < count; ++i) {
        require_input(std::isfinite(array.values[i]), "{}: value {} is {}", item, i, array.values[i]);
    }
    return array;
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

NpzFile::NpzFile(const std::string& path) : path_(path), bytes_(read_file(path))
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
        std::string name(bytes.substr(at + central_size, name_size));
        Entry entry;
        entry.method = number_at(bytes, at + 10, 2);
        entry.checksum = number_at(bytes, at + 16, 4);
        entry.packed_size = number_at(bytes, at + 20, 4);
        entry.size = number_at(bytes, at + 24, 4);
        entry.header = number_at(bytes, at + 42, 4);
        require_input((number_at(bytes, at + 8, 2) & 1U) == 0, "{}: {} is encrypted", path, name);
        at += central_size + rest;
        constexpr std::string_view suffix = ".npy";
        if (name.size() <= suffix.size() || name.compare(name.size() - 4, 4, suffix) != 0) continue;
        name.resize(name.size() - suffix.size());
        require_input(entries_.emplace(name, entry).second, "{}: holds \"{}\" twice", path, name);
    }
}

std::string NpzFile::unpack(const std::string& key) const
{
    const std::string_view bytes = bytes_;
    const auto found = entries_.find(key);
    require_input(found != entries_.end(), "{}: has no array \"{}\"", path_, key);
    const Entry& entry = found->second;
    require_input(entry.header < bytes.size() && bytes.size() - entry.header >= local_size &&
                      number_at(bytes, entry.header, 4) == local_signature,
                  "{}: \"{}\": there is no zip entry at byte {}", path_, key, entry.header);
    // Name and extra fields of the local header have lengths of their own.
    const std::size_t start =
        entry.header + local_size + number_at(bytes, entry.header + 26, 2) + number_at(bytes, entry.header + 28, 2);
    require_input(start <= bytes.size() && entry.packed_size <= bytes.size() - start,
                  "{}: \"{}\": has {} packed bytes, which reach past the end of the file", path_, key,
                  entry.packed_size);
    const std::string_view packed = bytes.substr(start, entry.packed_size);
    require_input(entry.method == 0 || entry.method == 8,
                  "{}: \"{}\": is packed by zip method {}, not stored or deflated", path_, key, entry.method);
    std::string unpacked;
    if (entry.method == 0) {
        require_input(entry.size == entry.packed_size, "{}: \"{}\": has {} bytes stored as {}", path_, key, entry.size,
                      entry.packed_size);
        unpacked = packed;
    } else {
        require_input(entry.size / largest_ratio <= entry.packed_size,
                      "{}: \"{}\": {} packed bytes cannot hold the {} it announces", path_, key, entry.packed_size,
                      entry.size);
        unpacked.resize(entry.size);
        require_input(inflate_raw(packed, unpacked), "{}: \"{}\": its {} packed bytes cannot be unpacked", path_, key,
                      entry.packed_size);
    }
    const auto checksum =
        static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(unpacked.data()), unpacked.size()));
    require_input(checksum == entry.checksum, "{}: \"{}\": its checksum is {:08x}, not {:08x}", path_, key, checksum,
                  entry.checksum);
    return unpacked;
}

NpyArray NpzFile::read(const std::string& key) const
{
    return parse_npy(unpack(key), fmt::format("{}: \"{}\"", path_, key));
}

}  // namespace ndg
