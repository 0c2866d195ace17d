// SPDX-License-Identifier: Apache-2.0
// JSON files as people write them: a value knows its file and its place in it, so that every error names both.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ndg {

/// A value of a JSON file. What asks for another type, a missing or unknown key, or a value outside its range throws
/// InputError: "FILE: joints.shin.x: expected a number in [0, 1], got 2".
class JsonValue {
public:
    /// Reads a file. Throws InputError naming it, and the line that is not valid JSON or the key that stands twice in
    /// one object (the library would keep the last).
    explicit JsonValue(const std::string& path);

    const nlohmann::json& json() const { return *json_; }
    /// "FILE: joints.shin.x", "FILE" for the whole.
    std::string where() const;

    bool is_object() const;
    bool is_list() const;
    bool is_text() const;

    /// Names the nearest known key for one that is not `known`.
    void check_keys(const std::vector<std::string>& known) const;
    /// Whether the object has the key.
    bool has(const std::string& key) const;
    /// Member of the object.
    JsonValue at(const std::string& key) const;
    /// Members of an object, in the order of their keys.
    std::vector<std::pair<std::string, JsonValue>> members() const;

    /// Elements of a list of `count`, or of any length.
    std::vector<JsonValue> elements(int count = -1) const;
    /// The same where all are finite numbers.
    std::vector<double> numbers(int count = -1) const;

    /// Finite, from `low` to `high`.
    double number(double low = -unbounded, double high = unbounded) const;
    int integer(int low, int high = std::numeric_limits<int>::max()) const;
    bool flag() const;
    std::string text() const;
    /// Text that is one of `names`: its index.
    int choice(const std::vector<std::string>& names) const;

    /// Member of an object, or `fallback` where there is none.
    double number_or(const std::string& key, double fallback, double low, double high) const;
    bool flag_or(const std::string& key, bool fallback) const;
    std::string text_or(const std::string& key, const std::string& fallback) const;

    /// Throws "WHERE: expected EXPECTED, got VALUE" unless `condition` holds.
    void expect(bool condition, const std::string& expected) const;

private:
    static constexpr double unbounded = std::numeric_limits<double>::max();
    JsonValue(const JsonValue& parent, const nlohmann::json& value, const std::string& step);

    std::shared_ptr<const std::string> path_;
    std::shared_ptr<const nlohmann::json> root_;  ///< holds what json_ points to
    const nlohmann::json* json_ = nullptr;
    std::string place_;  ///< "joints.shin.x"
};

}  // namespace ndg
