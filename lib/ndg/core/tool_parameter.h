// SPDX-License-Identifier: Apache-2.0
// Private to core: one parameter of a Tool, settable from the command line and from JSON under the same rules.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace ndg {

struct ToolParameter {
    std::string flag;  ///< kebab-case, without dashes
    std::string help;
    std::variant<double*, int*, bool*, std::uint64_t*, std::vector<int>*, std::string*> value;
    double low = 0.0, high = 0.0;      ///< of double and int
    std::vector<std::string> choices;  ///< of text; empty: any

    std::vector<std::string> words;  ///< as given on the command line
    bool given = false;              ///< on the command line
    bool flag_value = false;         ///< of bool, on the command line

    std::string key() const;  ///< the flag in snake_case
    bool is_flag() const { return std::holds_alternative<bool*>(value); }
    bool is_list() const { return std::holds_alternative<std::vector<int>*>(value); }

    /// "NUM", "INT", "INT,INT,..." or "TEXT".
    std::string value_name() const;
    /// "[0.1, 3]", ">= 0", "a, b or c"; empty when anything goes.
    std::string range_text() const;
    std::string value_text() const;
    nlohmann::json to_json() const;

    /// Takes the value given on the command line. Throws InputError naming flag, value and what is expected.
    void take_words();
    /// `where` names the file. Throws InputError naming file, key, value and what is expected.
    void take_json(const nlohmann::json& json, const std::string& where);

private:
    /// Checks range or choices and stores. `name` and `shown` are for the message.
    void store(const nlohmann::json& json, const std::string& name, const std::string& shown);
    std::string expected() const;
};

/// The known name with the smallest edit distance to `name`; empty if `known` is.
std::string nearest_name(const std::string& name, const std::vector<std::string>& known);

}  // namespace ndg
