// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/schema.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>

namespace ndg {
namespace {

/// What the sizes of one file are, and by which item.
struct Size {
    std::size_t value = 0;
    std::string set_by;
};
using Sizes = std::map<std::string, Size>;

std::vector<std::string_view> split(std::string_view text, std::string_view separator)
{
    std::vector<std::string_view> parts;
    for (std::size_t end = 0; (end = text.find(separator)) != std::string_view::npos;) {
        parts.push_back(text.substr(0, end));
        text.remove_prefix(end + separator.size());
    }
    parts.push_back(text);
    return parts;
}

/// Whether `name` is what `pattern` stands for; `word` becomes the text in the place of "<word>".
bool matches(const std::string& pattern, const std::string& name, std::string& word)
{
    const std::size_t begin = pattern.find('<'), end = pattern.find('>');
    if (begin == std::string::npos) return pattern == name;
    const std::size_t tail = pattern.size() - end - 1;
    if (name.size() <= begin + tail || name.compare(0, begin, pattern, 0, begin) != 0 ||
        name.compare(name.size() - tail, tail, pattern, end + 1, tail) != 0)
        return false;
    word = name.substr(begin, name.size() - begin - tail);
    return word.find('/') == std::string::npos;
}

/// "9 N_p" as (9, "N_p"), "3" as (3, ""), "B_<split>" as (1, "B_train").
std::pair<std::size_t, std::string> parse_extent(std::string_view text, const std::string& word)
{
    std::size_t factor = 1;
    const auto parsed = std::from_chars(text.data(), text.data() + text.size(), factor);
    text.remove_prefix(static_cast<std::size_t>(parsed.ptr - text.data()));
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    std::string name(text);
    const std::size_t begin = name.find('<');
    if (begin != std::string::npos) name.replace(begin, name.find('>') - begin + 1, word);
    return {factor, name};
}

/// Whether the item has this shape; sizes that it names first are added to `sizes`.
bool fits(const FileItem& item, std::string_view shape, const std::string& word, Sizes& sizes)
{
    if (shape.empty()) return item.shape.empty();
    const std::vector<std::string_view> axes = split(shape, " x ");
    if (axes.size() != item.shape.size()) return false;
    Sizes found = sizes;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        const auto [factor, name] = parse_extent(axes[axis], word);
        const std::size_t extent = item.shape[axis];
        if (name.empty() ? extent != factor : extent % factor != 0) return false;
        if (name.empty()) continue;
        const Size& size = found.emplace(name, Size{extent / factor, item.name}).first->second;
        if (size.value * factor != extent) return false;
    }
    sizes = std::move(found);
    return true;
}

bool fits_any(const FileItem& item, const std::string& shapes, const std::string& word, Sizes& sizes)
{
    const std::vector<std::string_view> alternatives = split(shapes, " or ");
    return std::any_of(alternatives.begin(), alternatives.end(),
                       [&](std::string_view shape) { return fits(item, shape, word, sizes); });
}

std::string shape_text(const FileItem& item)
{
    return item.shape.empty() ? "a single value" : fmt::format("{}", fmt::join(item.shape, " x "));
}

/// "N_s = 10 of /skin/vertices" for every size of the shape that is known.
std::string sizes_text(const std::string& shapes, const std::string& word, const Sizes& sizes)
{
    std::string text;
    for (const std::string_view shape : split(shapes, " or "))
        for (const std::string_view axis : split(shape, " x ")) {
            const auto found = sizes.find(parse_extent(axis, word).second);
            if (found == sizes.end()) continue;
            text += fmt::format("{}{} = {} of {}", text.empty() ? ", where " : ", ", found->first, found->second.value,
                                found->second.set_by);
        }
    return text;
}

const Schema* find_schema(const std::string& format)
{
    const auto found =
        std::find_if(schemas().begin(), schemas().end(), [&](const Schema& schema) { return schema.format == format; });
    return found == schemas().end() ? nullptr : &*found;
}

}  // namespace

void check_format(const std::string& format, int version)
{
    if (format.rfind("test-", 0) == 0) return;
    const Schema* schema = find_schema(format);
    require(schema != nullptr, "The format \"{}\" has no schema", format);
    require(schema->version == version, "The format \"{}\" has version {}, not {}", format, schema->version, version);
}

std::string schema_violation(const std::string& format, const std::vector<FileItem>& items)
{
    const Schema* schema = find_schema(format);
    if (schema == nullptr) return "";
    std::vector<bool> known(items.size(), false);
    Sizes sizes;
    std::string word;
    for (const SchemaItem& common : common_attributes())
        for (std::size_t i = 0; i < items.size(); ++i)
            if (items[i].name == common.name) known[i] = true;
    // In the schema's order, in which sizes are named before they stand in alternatives.
    for (const SchemaItem& wanted : schema->items) {
        bool present = false;
        for (std::size_t i = 0; i < items.size(); ++i) {
            const FileItem& item = items[i];
            if (known[i] || !matches(wanted.name, item.name, word)) continue;
            known[i] = present = true;
            if (item.type != wanted.type)
                return fmt::format("{} holds {}, the schema of {} says {}", item.name, item.type, format, wanted.type);
            if (!fits_any(item, wanted.shape, word, sizes))
                return fmt::format("{} is {}, the schema of {} says {}{}", item.name, shape_text(item), format,
                                   wanted.shape, sizes_text(wanted.shape, word, sizes));
        }
        if (!present && !wanted.optional) return fmt::format("{} is missing", wanted.name);
    }
    const auto unknown = std::find(known.begin(), known.end(), false);
    if (unknown == known.end()) return "";
    return fmt::format("{} is not in the schema of {}", items[unknown - known.begin()].name, format);
}

}  // namespace ndg
