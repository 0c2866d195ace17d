// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/options.h"

#include "ndg/core/error.h"
#include "ndg/core/option_json.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {

Option& Option::run_only()
{
    affects_result = false;
    return *this;
}

Option& Option::no_flag()
{
    has_flag = false;
    return *this;
}

std::string Option::key() const
{
    std::string name = flag;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

std::string Option::value_name() const
{
    if (holds<bool*>()) return "";
    if (holds<double*>()) return "NUM";
    if (holds<std::vector<int>*>()) return "INT,INT,...";
    return holds<int*>() || holds<std::uint64_t*>() ? "INT" : "TEXT";
}

std::string Option::range_text() const
{
    if (!choices.empty()) return fmt::format("{}", fmt::join(choices, " | "));
    if (!holds<double*>() && !holds<int*>() && !holds<std::vector<int>*>()) return "";
    const bool below = low <= std::numeric_limits<int>::min(), above = high >= std::numeric_limits<int>::max();
    if (below && above) return "";
    if (above) return fmt::format(">= {}", low);
    if (below) return fmt::format("<= {}", high);
    return fmt::format("[{}, {}]", low, high);
}

std::string Option::expected() const
{
    const std::string range = range_text();
    if (!choices.empty()) return "one of " + range;
    if (holds<bool*>()) return "true or false";
    if (holds<std::string*>()) return "a text that is not empty";
    if (holds<std::uint64_t*>()) return "an integer >= 0";
    const std::string what = holds<double*>() ? "a number" : holds<int*>() ? "an integer" : "a list of integers";
    if (range.empty()) return what;
    return what + (range.front() == '[' ? " in " : " ") + range;
}

std::string Option::value_text() const
{
    if (holds<EnumReference>() || holds<std::string*>()) return to_json(*this).get<std::string>();
    if (const auto* number = std::get_if<double*>(&value)) return fmt::format("{}", **number);
    if (const auto* list = std::get_if<std::vector<int>*>(&value)) return fmt::format("{}", fmt::join(**list, ","));
    return to_json(*this).dump();
}

bool Option::contains(double number) const
{
    return std::isfinite(number) && number >= low && number <= high;
}

void Option::check() const
{
    bool good = true;
    if (const auto* number = std::get_if<double*>(&value)) good = contains(**number);
    if (const auto* number = std::get_if<int*>(&value)) good = contains(**number);
    if (const auto* list = std::get_if<std::vector<int>*>(&value)) {
        good = std::all_of((*list)->begin(), (*list)->end(), [this](int number) { return contains(number); });
    }
    if (const auto* text = std::get_if<std::string*>(&value)) {
        good = choices.empty() || std::find(choices.begin(), choices.end(), **text) != choices.end();
    }
    require_input(good, "{}: expected {}, got {}", flag, expected(), value_text());
}

Option& OptionList::add(const std::string& flag, double& value, const std::string& help, double low, double high)
{
    Option& option = append(flag, help, &value);
    option.low = low;
    option.high = high;
    return option;
}

Option& OptionList::add(const std::string& flag, int& value, const std::string& help, int low, int high)
{
    Option& option = append(flag, help, &value);
    option.low = low;
    option.high = high;
    return option;
}

Option& OptionList::add(const std::string& flag, std::uint64_t& value, const std::string& help)
{
    return append(flag, help, &value);
}

Option& OptionList::add(const std::string& flag, bool& value, const std::string& help)
{
    return append(flag, help, &value);
}

Option& OptionList::add(const std::string& flag, std::vector<int>& value, const std::string& help, int low, int high)
{
    Option& option = append(flag, help, &value);
    option.low = low;
    option.high = high;
    return option;
}

Option& OptionList::add(const std::string& flag, std::string& value, const std::string& help,
                        const std::vector<std::string>& choices)
{
    Option& option = append(flag, help, &value);
    option.choices = choices;
    return option;
}

Option& OptionList::append(const std::string& flag, const std::string& help, decltype(Option::value) value)
{
    for (const Option& other : options_) require(other.flag != flag, "the option {} is described twice", flag);
    Option option;
    option.flag = flag;
    option.help = help;
    option.value = value;
    return options_.emplace_back(std::move(option));
}

void check_options(const OptionList& list)
{
    for (const Option& option : list.options()) option.check();
}

std::string options_key(const OptionList& list)
{
    nlohmann::json values = nlohmann::json::object();
    for (const Option& option : list.options()) {
        if (option.affects_result) values[option.key()] = to_json(option);
    }
    return values.dump();
}

}  // namespace ndg
