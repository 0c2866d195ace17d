// SPDX-License-Identifier: Apache-2.0
// Enums that stand in files, flags and tables by name: one table of names an enum.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ndg {

template <typename Enum>
struct EnumName {
    Enum value;
    const char* name;
};

/// The table of an enum, in the order in which its names are listed. Specialised beside the enum:
///     enum class Side { left, right };
///     template <>
///     inline constexpr EnumName<Side> enum_table<Side>[] = {{Side::left, "left"}, {Side::right, "right"}};
template <typename Enum>
inline constexpr std::nullptr_t enum_table = nullptr;

[[noreturn]] void throw_value_without_name(int value);
[[noreturn]] void throw_unknown_name(std::string_view text, const std::string& what,
                                     const std::vector<std::string>& known);

/// Throws Error for a value without a name.
template <typename Enum>
std::string to_name(Enum value)
{
    for (const EnumName<Enum>& entry : enum_table<Enum>) {
        if (entry.value == value) return entry.name;
    }
    throw_value_without_name(static_cast<int>(value));
}

/// All names, in the table's order.
template <typename Enum>
std::vector<std::string> names()
{
    std::vector<std::string> list;
    for (const EnumName<Enum>& entry : enum_table<Enum>) list.emplace_back(entry.name);
    return list;
}

/// Empty for a name that the table lacks.
template <typename Enum>
std::optional<Enum> find_name(std::string_view name)
{
    for (const EnumName<Enum>& entry : enum_table<Enum>) {
        if (name == entry.name) return entry.value;
    }
    return std::nullopt;
}

/// `what`: file and item, for the message. Throws InputError naming it, the text and the names there are.
template <typename Enum>
Enum parse_name(std::string_view text, const std::string& what = "")
{
    const std::optional<Enum> found = find_name<Enum>(text);
    if (!found) throw_unknown_name(text, what, names<Enum>());
    return *found;
}

}  // namespace ndg
