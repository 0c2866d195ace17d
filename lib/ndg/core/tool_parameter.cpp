// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool_parameter.h"

#include "ndg/core/error.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

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

std::string number_text(double number)
{
    return fmt::format("{}", number);
}

bool is_unbounded_below(double low)
{
    return low <= static_cast<double>(std::numeric_limits<int>::min());
}
bool is_unbounded_above(double high)
{
    return high >= static_cast<double>(std::numeric_limits<int>::max());
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

}  // namespace

std::string ToolParameter::key() const
{
    std::string name = flag;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

std::string ToolParameter::value_name() const
{
    if (is_flag()) return "";
    if (is_list()) return "INT,INT,...";
    if (std::holds_alternative<double*>(value)) return "NUM";
    if (std::holds_alternative<std::string*>(value)) return "TEXT";
    return "INT";
}

std::string ToolParameter::range_text() const
{
    if (!choices.empty()) return fmt::format("{}", fmt::join(choices, " | "));
    if (!std::holds_alternative<double*>(value) && !std::holds_alternative<int*>(value)) return "";
    const bool below = is_unbounded_below(low), above = is_unbounded_above(high);
    if (below && above) return "";
    if (above) return ">= " + number_text(low);
    if (below) return "<= " + number_text(high);
    return fmt::format("[{}, {}]", number_text(low), number_text(high));
}

std::string ToolParameter::expected() const
{
    const std::string range = range_text();
    if (!choices.empty()) return "one of " + range;
    if (is_flag()) return "true or false";
    if (is_list()) return "a list of integers";
    if (std::holds_alternative<std::string*>(value)) return "a text that is not empty";
    if (std::holds_alternative<std::uint64_t*>(value)) return "an integer >= 0";
    const std::string what = std::holds_alternative<double*>(value) ? "a number" : "an integer";
    if (range.empty()) return what;
    return what + (range.front() == '[' ? " in " : " ") + range;
}

json ToolParameter::to_json() const
{
    return std::visit([](const auto* stored) { return json(*stored); }, value);
}

std::string ToolParameter::value_text() const
{
    if (const auto* text = std::get_if<std::string*>(&value)) return **text;
    if (const auto* number = std::get_if<double*>(&value)) return number_text(**number);
    if (const auto* list = std::get_if<std::vector<int>*>(&value)) return fmt::format("{}", fmt::join(**list, ","));
    return to_json().dump();
}

void ToolParameter::take_words()
{
    const std::string name = "--" + flag;
    if (is_flag()) return store(json(flag_value), name, flag_value ? "true" : "false");
    std::string text = fmt::format("{}", fmt::join(words, ","));
    json parsed;
    if (std::holds_alternative<std::string*>(value)) {
        parsed = text;
    } else if (std::holds_alternative<double*>(value)) {
        parsed = parse_number<double>(text);
    } else if (std::holds_alternative<int*>(value)) {
        parsed = parse_number<std::int64_t>(text);
    } else if (std::holds_alternative<std::uint64_t*>(value)) {
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
    store(parsed, name, "'" + text + "'");
}

void ToolParameter::take_json(const json& given_value, const std::string& where)
{
    store(given_value, where + "." + key(), given_value.dump());
}

void ToolParameter::store(const json& given_value, const std::string& name, const std::string& shown)
{
    const auto check = [&](bool good) { require_input(good, "{}: expected {}, got {}", name, expected(), shown); };
    if (auto* number = std::get_if<double*>(&value)) {
        check(given_value.is_number());
        const double candidate = given_value.get<double>();
        check(std::isfinite(candidate) && candidate >= low && candidate <= high);
        **number = candidate;
    } else if (auto* integer = std::get_if<int*>(&value)) {
        check(fits_int(given_value));
        const int candidate = given_value.get<int>();
        check(candidate >= low && candidate <= high);
        **integer = candidate;
    } else if (auto* boolean = std::get_if<bool*>(&value)) {
        check(given_value.is_boolean());
        **boolean = given_value.get<bool>();
    } else if (auto* natural = std::get_if<std::uint64_t*>(&value)) {
        // A literal built in code may be a signed integer that is not negative.
        check(given_value.is_number_unsigned() ||
              (given_value.is_number_integer() && given_value.get<std::int64_t>() >= 0));
        **natural = given_value.get<std::uint64_t>();
    } else if (auto* list = std::get_if<std::vector<int>*>(&value)) {
        check(given_value.is_array());
        for (const json& element : given_value) check(fits_int(element));
        **list = given_value.get<std::vector<int>>();
    } else if (auto* text = std::get_if<std::string*>(&value)) {
        check(given_value.is_string());
        const auto candidate = given_value.get<std::string>();
        const bool known = std::find(choices.begin(), choices.end(), candidate) != choices.end();
        check(choices.empty() ? !candidate.empty() : known);
        **text = candidate;
    }
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
