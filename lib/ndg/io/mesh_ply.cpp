// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/text_file.h"
#include "ndg/io/mesh_parts.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>

namespace ndg::mesh {
namespace {

/// A type of the format, under both of its names.
struct Scalar {
    std::string_view name, sized_name;
    std::size_t num_bytes;
    bool is_real;
    double (*value)(const char* bytes);
};

template <typename T>
constexpr Scalar scalar(std::string_view name, std::string_view sized_name)
{
    return {name, sized_name, sizeof(T), std::is_floating_point_v<T>, [](const char* bytes) {
                T value{};
                std::memcpy(&value, bytes, sizeof value);
                return static_cast<double>(value);
            }};
}

constexpr std::array<Scalar, 8> scalars = {
    {scalar<std::int8_t>("char", "int8"), scalar<std::uint8_t>("uchar", "uint8"),
     scalar<std::int16_t>("short", "int16"), scalar<std::uint16_t>("ushort", "uint16"),
     scalar<std::int32_t>("int", "int32"), scalar<std::uint32_t>("uint", "uint32"), scalar<float>("float", "float32"),
     scalar<double>("double", "float64")}};

struct Property {
    std::string name;
    const Scalar* type = nullptr;
    const Scalar* count_type = nullptr;  ///< of a list

    bool is_list() const { return count_type != nullptr; }
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    bool binary = false;
    std::vector<Element> elements;
    std::size_t num_lines = 0, num_bytes = 0;
};

const Scalar* parse_scalar(std::string_view word, const std::string& where)
{
    for (const Scalar& type : scalars)
        if (type.name == word || type.sized_name == word) return &type;
    throw InputError(fmt::format("{}: unknown PLY type '{}'", where, word));
}

Header read_header(const std::string& path, std::string_view content)
{
    Header header;
    LineReader lines(content);
    std::string_view line;
    const auto first_words = lines.next(line) ? split_words(line) : std::vector<std::string_view>();
    require_input(first_words.size() == 1 && equal_without_case(first_words[0], "ply"),
                  "{}: does not begin with \"ply\"", path);
    bool has_format = false;
    while (lines.next(line)) {
        const std::string where = fmt::format("{}: line {}", path, lines.number());
        const auto words = split_words(line);
        if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words[0] == "end_header") {
            require_input(has_format, "{}: the format line is missing", where);
            header.num_lines = lines.number();
            header.num_bytes = content.size() - lines.bytes_left();
            return header;
        }
        if (words[0] == "format" && words.size() == 3) {
            has_format = true;
            header.binary = words[1] == "binary_little_endian";
            require_input(header.binary || words[1] == "ascii",
                          "{}: PLY format '{}' is not supported, use ascii or binary_little_endian", where, words[1]);
        } else if (words[0] == "element" && words.size() == 3) {
            const long long count = parse_integer(words[2], where);
            require_input(count >= 0, "{}: {} elements", where, count);
            header.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(count), {}});
        } else if (words[0] == "property" && words.size() == 3 && !header.elements.empty()) {
            header.elements.back().properties.push_back(
                {std::string(words[2]), parse_scalar(words[1], where), nullptr});
        } else if (words[0] == "property" && words.size() == 5 && words[1] == "list" && !header.elements.empty()) {
            const Scalar* count_type = parse_scalar(words[2], where);
            require_input(!count_type->is_real, "{}: a list cannot be counted in '{}'", where, words[2]);
            header.elements.back().properties.push_back(
                {std::string(words[4]), parse_scalar(words[3], where), count_type});
        } else {
            throw InputError(fmt::format("{}: cannot understand '{}'", where, line.substr(0, 60)));
        }
    }
    throw InputError(fmt::format("{}: truncated, the header has no end", path));
}

/// Values of the body one after the other.
class Source {
public:
    virtual ~Source() = default;
    virtual double next(const Scalar& type, const std::string& where) = 0;  ///< may be no finite number
    virtual std::size_t bytes_left() const = 0;
    virtual std::size_t least_bytes(const Scalar& type) const = 0;
};

class BinarySource : public Source {
public:
    explicit BinarySource(std::string_view body) : body_(body) {}
    std::size_t bytes_left() const override { return body_.size(); }
    std::size_t least_bytes(const Scalar& type) const override { return type.num_bytes; }
    double next(const Scalar& type, const std::string& where) override
    {
        require_input(body_.size() >= type.num_bytes, "{}: truncated", where);
        const double value = type.value(body_.data());
        body_.remove_prefix(type.num_bytes);
        return value;
    }

private:
    std::string_view body_;
};

class TextSource : public Source {
public:
    explicit TextSource(std::string_view body) : lines_(body) {}
    std::size_t bytes_left() const override { return lines_.bytes_left(); }
    std::size_t least_bytes(const Scalar&) const override { return 2; }  // a digit and a blank
    double next(const Scalar& type, const std::string& where) override
    {
        while (word_ >= words_.size()) {
            std::string_view line;
            require_input(lines_.next(line), "{}: truncated", where);
            words_ = split_words(line);
            word_ = 0;
        }
        const std::string_view word = words_[word_++];
        if (type.is_real) return parse_number(word, where);
        return static_cast<double>(parse_integer(word, where));
    }

private:
    LineReader lines_;
    std::vector<std::string_view> words_;
    std::size_t word_ = 0;
};

/// A list of the header promises its count alone, everything else its value.
void check_counts(const std::string& path, const Header& header, const Source& source)
{
    std::size_t bytes_left = source.bytes_left() + 1;  // the last line of a text may have no end
    for (const Element& element : header.elements) {
        std::size_t bytes = 0;
        for (const Property& property : element.properties) {
            bytes += source.least_bytes(property.is_list() ? *property.count_type : *property.type);
        }
        require_input(bytes > 0, "{}: element {} has no properties", path, element.name);
        require_input(element.count <= bytes_left / bytes, "{}: truncated, {} elements {} do not fit into its {} bytes",
                      path, element.count, element.name, source.bytes_left());
        bytes_left -= element.count * bytes;
    }
}

void read_list(const Property& property, Source& source, const std::string& where, std::vector<long long>* values)
{
    const double count = source.next(*property.count_type, where);
    require_input(count >= 0, "{}: a list of {} values", where, count);
    for (auto i = static_cast<std::int64_t>(count); i > 0; --i) {
        const double value = source.next(*property.type, where);
        if (values != nullptr) values->push_back(static_cast<long long>(value));
    }
}

void read_element(const Element& element, std::uint64_t index, Source& source, MeshBuilder& builder)
{
    const std::string where = fmt::format("{}: {} {}", builder.path(), element.name, index);
    std::array<double, 3> position{};
    std::vector<long long> corners;
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    for (const Property& property : element.properties) {
        if (property.is_list()) {
            const bool wanted = is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
            read_list(property, source, where, wanted ? &corners : nullptr);
        } else {
            const double value = source.next(*property.type, where);
            if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z') {
                position[property.name[0] - 'x'] = value;
            }
        }
    }
    if (is_vertex) builder.add_vertex(position[0], position[1], position[2], where);
    if (is_face) {
        require_input(corners.size() >= 3, "{}: a face needs three vertices, got {}", where, corners.size());
        builder.add_polygon(corners, "", index);
    }
}

void check_properties(const std::string& path, const Header& header)
{
    int num_vertex_elements = 0;
    for (const Element& element : header.elements) {
        const auto has = [&element](bool is_list, std::string_view name) {
            for (const Property& property : element.properties) {
                if (property.is_list() == is_list && property.name == name) return !(is_list && property.type->is_real);
            }
            return false;
        };
        if (element.name == "vertex") {
            ++num_vertex_elements;
            for (const char* name : {"x", "y", "z"}) {
                require_input(has(false, name), "{}: vertices have no property {}", path, name);
            }
        }
        if (element.name == "face") {
            require_input(has(true, "vertex_indices") || has(true, "vertex_index"),
                          "{}: faces have no list of integers vertex_indices", path);
        }
    }
    require_input(num_vertex_elements == 1, "{}: {} elements \"vertex\", expected one", path, num_vertex_elements);
}

}  // namespace

MeshFile read_ply(const std::string& path, std::string content, const MeshReading& reading)
{
    // Only the header of a binary file is text.
    const std::string_view head = std::string_view(content).substr(0, 4096);
    const bool is_wide =
        head.find('\0') < 4 || content.compare(0, 2, "\xFF\xFE") == 0 || content.compare(0, 2, "\xFE\xFF") == 0;
    if (is_wide || head.find("format ascii") != std::string_view::npos) {
        content = normalise_text(path, std::move(content));
    } else if (content.compare(0, 3, "\xEF\xBB\xBF") == 0) {
        content.erase(0, 3);
    }
    const Header header = read_header(path, content);
    check_properties(path, header);
    const std::string_view body = std::string_view(content).substr(header.num_bytes);
    std::unique_ptr<Source> source;
    if (header.binary) {
        source = std::make_unique<BinarySource>(body);
    } else {
        source = std::make_unique<TextSource>(body);
    }
    check_counts(path, header, *source);
    MeshBuilder builder(path, reading.drop_invalid);
    for (const Element& element : header.elements) {
        for (std::uint64_t i = 0; i < element.count; ++i) read_element(element, i, *source, builder);
    }
    return std::move(builder).finish("face", 0);
}

}  // namespace ndg::mesh
