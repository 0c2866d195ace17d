// SPDX-License-Identifier: Apache-2.0
// What can be chosen about a method, described once: flags, keys of config files, ranges, checks and the key of a
// resumable run all come from that description.
#pragma once

#include "ndg/core/enum_names.h"

#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace ndg {

/// An enum behind its name table.
struct EnumReference {
    void* value = nullptr;
    std::size_t size = 0;
    std::string (*name)(const void* value) = nullptr;
    /// Throws InputError for a name the table lacks.
    void (*set)(void* value, const std::string& name) = nullptr;
};

/// One option: a reference to its value, and what is known of it.
struct Option {
    std::string flag;  ///< kebab-case, without dashes
    std::string help;
    std::variant<double*, int*, bool*, std::uint64_t*, std::vector<int>*, std::string*, EnumReference> value;
    double low = 0, high = 0;          ///< of a number, or of every number of a list
    std::vector<std::string> choices;  ///< of a text or enum; empty: any text
    bool affects_result = true;
    bool has_flag = true;

    /// Says how a run goes, not what comes out: is left out of options_key.
    Option& run_only();
    /// Set from code alone: no flag and no key in config files, but checked and in options_key like any other.
    Option& no_flag();

    template <typename T>
    bool holds() const
    {
        return std::holds_alternative<T>(value);
    }
    /// The flag in snake_case.
    std::string key() const;
    /// "NUM", "INT", "INT,INT,...", "TEXT", or nothing for a bool.
    std::string value_name() const;
    /// "[0.1, 3]", ">= 0", "a | b"; empty when anything goes.
    std::string range_text() const;
    /// "a number in [0.1, 3]", for messages.
    std::string expected() const;
    std::string value_text() const;
    /// Whether a number lies within the range; no for NaN and infinity.
    bool contains(double number) const;
    /// Throws InputError naming flag, range and value unless the value lies in its range.
    void check() const;
};

/// The options of one struct, or of several. Keeps references to the values.
class OptionList {
public:
    /// Values outside [low, high] are input errors. The value at registration is the default. Returns the option, for
    /// run_only() and no_flag(). Throws Error for a flag that is there already.
    Option& add(const std::string& flag, double& value, const std::string& help, double low, double high);
    Option& add(const std::string& flag, int& value, const std::string& help, int low, int high);
    Option& add(const std::string& flag, std::uint64_t& value, const std::string& help);
    Option& add(const std::string& flag, bool& value, const std::string& help);
    /// The range is that of each entry.
    Option& add(const std::string& flag, std::vector<int>& value, const std::string& help,
                int low = std::numeric_limits<int>::min(), int high = std::numeric_limits<int>::max());
    /// `choices` empty: any text that is not empty, or the default.
    Option& add(const std::string& flag, std::string& value, const std::string& help,
                const std::vector<std::string>& choices = {});
    template <typename Enum, typename = std::enable_if_t<std::is_enum_v<Enum>>>
    Option& add(const std::string& flag, Enum& value, const std::string& help)
    {
        const auto name = [](const void* stored) { return to_name(*static_cast<const Enum*>(stored)); };
        const auto set = [](void* stored, const std::string& text) {
            *static_cast<Enum*>(stored) = parse_name<Enum>(text);
        };
        Option& option = append(flag, help, EnumReference{&value, sizeof(Enum), name, set});
        option.choices = names<Enum>();
        return option;
    }
    /// No value is "auto".
    template <typename Enum, typename = std::enable_if_t<std::is_enum_v<Enum>>>
    Option& add(const std::string& flag, std::optional<Enum>& value, const std::string& help)
    {
        using Value = std::optional<Enum>;
        const auto name = [](const void* stored) {
            const Value& given = *static_cast<const Value*>(stored);
            return given ? to_name(*given) : std::string("auto");
        };
        const auto set = [](void* stored, const std::string& text) {
            *static_cast<Value*>(stored) = text == "auto" ? Value() : parse_name<Enum>(text);
        };
        Option& option = append(flag, help, EnumReference{&value, sizeof(Value), name, set});
        option.choices = names<Enum>();
        option.choices.insert(option.choices.begin(), "auto");
        return option;
    }

    std::vector<Option>& options() { return options_; }
    const std::vector<Option>& options() const { return options_; }

private:
    Option& append(const std::string& flag, const std::string& help, decltype(Option::value) value);

    std::vector<Option> options_;
};

/// Throws InputError naming flag, range and value where one lies outside its range.
void check_options(const OptionList& list);
/// JSON text of all values that affect the result, in full precision.
std::string options_key(const OptionList& list);

/// The same for an options struct, described by a function `void describe(OptionList&, Options&)` beside it.
template <typename Options>
void check_options(Options options)
{
    OptionList list;
    describe(list, options);
    check_options(list);
}
template <typename Options>
std::string options_key(Options options)
{
    OptionList list;
    describe(list, options);
    return options_key(list);
}

}  // namespace ndg
