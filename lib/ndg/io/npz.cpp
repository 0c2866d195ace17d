// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/npz.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

namespace ndg {

namespace {

/// The header of a .npy file: {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }.
class NpyHeader {
public:
    NpyHeader(std::string_view text, std::string item) : text_(text), item_(std::move(item)) {}

    std::string type;
    std::vector<std::int64_t> shape;
    bool fortran_order = false;

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
                fortran_order = accept_word("True");
                if (!fortran_order && !accept_word("False")) fail();
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

/// Values of which the first index runs fastest, in the order in which the last does.
std::vector<double> c_ordered(const std::vector<double>& values, const std::vector<std::int64_t>& shape)
{
    std::vector<double> ordered(values.size());
    std::vector<std::int64_t> index(shape.size(), 0);
    for (const double value : values) {
        std::int64_t at = 0;
        for (std::size_t k = 0; k < shape.size(); ++k) at = at * shape[k] + index[k];
        ordered[static_cast<std::size_t>(at)] = value;
        for (std::size_t k = 0; k < shape.size() && ++index[k] == shape[k]; ++k) index[k] = 0;
    }
    return ordered;
}

NpyArray parse_npy(std::string_view bytes, const std::string& item, bool finite)
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
    for (std::size_t i = 0; finite && i < count; ++i) {
        require_input(std::isfinite(array.values[i]), "{}: value {} is {}", item, i, array.values[i]);
    }
    if (header.fortran_order && array.shape.size() > 1) array.values = c_ordered(array.values, array.shape);
    return array;
}

}  // namespace

NpyArray read_npy(const std::string& path, bool finite)
{
    return parse_npy(read_file(path), path, finite);
}

NpzFile::NpzFile(const std::string& path) : zip_(path) {}

std::vector<std::string> NpzFile::keys() const
{
    constexpr std::string_view extension = ".npy";
    std::vector<std::string> keys;
    for (const auto& [name, entry] : zip_.entries()) {
        if (name.size() <= extension.size() || name.substr(name.size() - extension.size()) != extension) continue;
        keys.push_back(name.substr(0, name.size() - extension.size()));
    }
    return keys;
}

NpyArray NpzFile::read(const std::string& key, bool finite) const
{
    require_input(has(key), "{}: has no array \"{}\"", path(), key);
    const std::string item = fmt::format("{}: \"{}\"", path(), key);
    return parse_npy(zip_.unpack(key + ".npy", item), item, finite);
}

}  // namespace ndg
