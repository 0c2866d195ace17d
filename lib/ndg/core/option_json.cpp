// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/option_json.h"

#include "ndg/core/error.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <numeric>
#include <type_traits>

namespace ndg {
namespace {

using nlohmann::json;

/// A JSON value of the wanted type from command-line text; null when the text is something else.
template <typename T>
json parse_number(const std::string& text)
{
    T number{};
    const char* begin = text.data();
    const char* end = begin + text.size();
    if (begin != end && *begin == '+') ++begin;
    const auto [last, error] = std::from_chars(begin, end, number);
    return error == std::errc() && last == end ? json(number) : json();
}

bool fits_int(const json& value)
{
    if (!value.is_number_integer()) return false;
    if (value.is_number_unsigned()) {
        return value.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<int>::max());
    }
    const auto number = value.get<std::int64_t>();
    return number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max();
}

/// Checks type, range or choices and stores. `name` and `shown` are for the message.
void store(Option& option, const json& given, const std::string& name, const std::string& shown)
{
    const auto check = [&](bool good) {
        require_input(good, "{}: expected {}, got {}", name, option.expected(), shown);
    };
    if (auto* number = std::get_if<double*>(&option.value)) {
        check(given.is_number() && option.contains(given.get<double>()));
        **number = given.get<double>();
    } else if (auto* integer = std::get_if<int*>(&option.value)) {
        check(fits_int(given) && option.contains(given.get<int>()));
        **integer = given.get<int>();
    } else if (auto* boolean = std::get_if<bool*>(&option.value)) {
        check(given.is_boolean());
        **boolean = given.get<bool>();
    } else if (auto* natural = std::get_if<std::uint64_t*>(&option.value)) {
        // A literal built in code may be a signed integer that is not negative.
        check(given.is_number_unsigned() || (given.is_number_integer() && given.get<std::int64_t>() >= 0));
        **natural = given.get<std::uint64_t>();
    } else if (auto* list = std::get_if<std::vector<int>*>(&option.value)) {
        check(given.is_array());
        for (const json& element : given) check(fits_int(element) && option.contains(element.get<int>()));
        **list = given.get<std::vector<int>>();
    } else {
        check(given.is_string());
        const auto candidate = given.get<std::string>();
        const std::vector<std::string>& choices = option.choices;
        const bool known = std::find(choices.begin(), choices.end(), candidate) != choices.end();
        check(choices.empty() ? !candidate.empty() : known);
        if (auto* text = std::get_if<std::string*>(&option.value)) {
            **text = candidate;
        } else {
            const auto& named = std::get<EnumReference>(option.value);
            named.set(named.value, candidate);
        }
    }
}

}  // namespace

json to_json(const Option& option)
{
    if (const auto* named = std::get_if<EnumReference>(&option.value)) return named->name(named->value);
    json value;
    std::visit(
        [&](const auto& stored) {
            if constexpr (std::is_pointer_v<std::decay_t<decltype(stored)>>) value = *stored;
        },
        option.value);
    return value;
}

void set_from_words(Option& option, const std::vector<std::string>& words)
{
    std::string text = fmt::format("{}", fmt::join(words, ","));
    json parsed;
    if (option.holds<bool*>()) {
        parsed = text == "true";
    } else if (option.holds<std::string*>() || option.holds<EnumReference>()) {
        parsed = text;
    } else if (option.holds<double*>()) {
        parsed = parse_number<double>(text);
    } else if (option.holds<int*>()) {
        parsed = parse_number<std::int64_t>(text);
    } else if (option.holds<std::uint64_t*>()) {
        parsed = parse_number<std::uint64_t>(text);
    } else {
        parsed = json::array();
        std::size_t begin = 0;
        while (!text.empty() && begin <= text.size()) {
            const std::size_t end = std::min(text.find(',', begin), text.size());
            parsed.push_back(parse_number<std::int64_t>(text.substr(begin, end - begin)));
            begin = end + 1;
        }
    }
    store(option, parsed, "--" + option.flag, "'" + text + "'");
}

void set_from_json(Option& option, const json& given, const std::string& where)
{
    store(option, given, where + "." + option.key(), given.dump());
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& known)
{
    // Levenshtein distance, one row at a time.
    const auto distance = [&name](const std::string& other) {
        std::vector<std::size_t> row(other.size() + 1);
        std::iota(row.begin(), row.end(), std::size_t{0});
        for (std::size_t i = 0; i < name.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i + 1;
            for (std::size_t j = 0; j < other.size(); ++j) {
                const std::size_t replaced = diagonal + (name[i] == other[j] ? 0 : 1);
                diagonal = row[j + 1];
                row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
            }
        }
        return row.back();
    };
    std::string nearest;
    std::size_t smallest = std::numeric_limits<std::size_t>::max();
    for (const std::string& candidate : known) {
        const std::size_t candidate_distance = distance(candidate);
        if (candidate_distance < smallest) {
            smallest = candidate_distance;
            nearest = candidate;
        }
    }
    return nearest;
}

}  // namespace ndg
