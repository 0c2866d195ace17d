// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/json_file.h"

#include "ndg/core/error.h"
#include "ndg/core/option_json.h"
#include "ndg/core/text_file.h"

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>

namespace ndg {
namespace {

using nlohmann::json;

/// Messages quote so much of a value.
constexpr std::size_t longest_shown = 100;

json parse(const std::string& path)
{
    const std::string text = read_text_file(path);
    std::vector<std::set<std::string>> open_objects;
    const auto check_repeated = [&](int, json::parse_event_t event, json& value) {
        if (event == json::parse_event_t::object_start) open_objects.emplace_back();
        if (event == json::parse_event_t::object_end) open_objects.pop_back();
        if (event == json::parse_event_t::key) {
            const auto key = value.get<std::string>();
            require_input(open_objects.back().insert(key).second, "{}: key \"{}\" stands twice in the same object",
                          path, key);
        }
        return true;
    };
    try {
        return json::parse(text, check_repeated);
    } catch (const json::parse_error& error) {
        const std::size_t end = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
        throw InputError(fmt::format("{}: line {}: not valid JSON", path, line));
    } catch (const json::exception& error) {  // a number too large for its type
        throw InputError(fmt::format("{}: not valid JSON: {}", path, error.what()));
    }
}

}  // namespace

JsonValue::JsonValue(const std::string& path)
    : path_(std::make_shared<const std::string>(path)), root_(std::make_shared<const nlohmann::json>(parse(path)))
{
    json_ = root_.get();
}

JsonValue::JsonValue(const JsonValue& parent, const nlohmann::json& value, const std::string& step)
    : path_(parent.path_), root_(parent.root_), json_(&value), place_(parent.place_ + step)
{
}

std::string JsonValue::where() const
{
    if (place_.empty()) return *path_;
    return *path_ + ": " + (place_[0] == '.' ? place_.substr(1) : place_);
}

bool JsonValue::is_object() const
{
    return json_->is_object();
}
bool JsonValue::is_list() const
{
    return json_->is_array();
}
bool JsonValue::is_text() const
{
    return json_->is_string();
}

void JsonValue::expect(bool condition, const std::string& expected) const
{
    if (condition) return;
    std::string shown = json_->dump(-1, ' ', true);
    if (shown.size() > longest_shown) shown = shown.substr(0, longest_shown) + "...";
    throw InputError(fmt::format("{}: expected {}, got {}", where(), expected, shown));
}

void JsonValue::check_keys(const std::vector<std::string>& known) const
{
    expect(is_object(), "an object");
    for (const auto& item : json_->items()) {
        require_input(std::find(known.begin(), known.end(), item.key()) != known.end(),
                      "{}: unknown key \"{}\", did you mean \"{}\"?", where(), item.key(),
                      nearest_name(item.key(), known));
    }
}

bool JsonValue::has(const std::string& key) const
{
    expect(is_object(), "an object");
    return json_->contains(key);
}

JsonValue JsonValue::at(const std::string& key) const
{
    require_input(has(key), "{}: has no \"{}\"", where(), key);
    return {*this, json_->at(key), "." + key};
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::members() const
{
    expect(is_object(), "an object");
    std::vector<std::pair<std::string, JsonValue>> result;
    for (const auto& item : json_->items()) {
        result.emplace_back(item.key(), JsonValue(*this, item.value(), "." + item.key()));
    }
    return result;
}

std::vector<JsonValue> JsonValue::elements(int count) const
{
    expect(is_list() && (count < 0 || json_->size() == static_cast<std::size_t>(count)),
           count < 0 ? "a list" : fmt::format("a list of {}", count));
    std::vector<JsonValue> result;
    for (const nlohmann::json& element : *json_) {
        result.push_back(JsonValue(*this, element, fmt::format("[{}]", result.size())));
    }
    return result;
}

std::vector<double> JsonValue::numbers(int count) const
{
    std::vector<double> result;
    for (const JsonValue& element : elements(count)) result.push_back(element.number());
    return result;
}

double JsonValue::number(double low, double high) const
{
    std::string expected = "a number";
    if (low > -unbounded || high < unbounded) expected += fmt::format(" in [{}, {}]", low, high);
    expect(json_->is_number(), expected);
    const double value = json_->get<double>();
    expect(std::isfinite(value) && value >= low && value <= high, expected);
    return value;
}

int JsonValue::integer(int low, int high) const
{
    const std::string expected = high == std::numeric_limits<int>::max()
                                     ? fmt::format("an integer >= {}", low)
                                     : fmt::format("an integer in [{}, {}]", low, high);
    expect(json_->is_number_integer(), expected);
    const double value = json_->get<double>();
    expect(value >= low && value <= high, expected);
    return json_->get<int>();
}

bool JsonValue::flag() const
{
    expect(json_->is_boolean(), "true or false");
    return json_->get<bool>();
}

std::string JsonValue::text() const
{
    expect(is_text(), "a text");
    return json_->get<std::string>();
}

int JsonValue::choice(const std::vector<std::string>& names) const
{
    const auto found = std::find(names.begin(), names.end(), is_text() ? text() : "");
    expect(is_text() && found != names.end(), fmt::format("one of {}", fmt::join(names, " | ")));
    return static_cast<int>(found - names.begin());
}

double JsonValue::number_or(const std::string& key, double fallback, double low, double high) const
{
    return has(key) ? at(key).number(low, high) : fallback;
}

bool JsonValue::flag_or(const std::string& key, bool fallback) const
{
    return has(key) ? at(key).flag() : fallback;
}

std::string JsonValue::text_or(const std::string& key, const std::string& fallback) const
{
    return has(key) ? at(key).text() : fallback;
}

}  // namespace ndg
