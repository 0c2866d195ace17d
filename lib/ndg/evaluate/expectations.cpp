// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/expectations.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"

namespace ndg {
namespace {

/// One table of the run, and what is expected of it.
class TableCheck {
public:
    TableCheck(std::string name, JsonValue found, std::vector<CheckedExpectation>& checks)
        : name_(std::move(name)), found_(std::move(found)), checks_(checks)
    {
    }

    void orders(const JsonValue& expected)
    {
        for (const auto& [measure, methods] : expected.members()) {
            const std::vector<JsonValue> chain = methods.elements();
            methods.expect(chain.size() >= 2, "at least two methods");
            for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
                const std::string better = chain[i].text(), worse = chain[i + 1].text();
                const double low = figure(better, measure), high = figure(worse, measure);
                add(fmt::format("{}: {} has less than {}: {:.4g} and {:.4g}", measure, better, worse, low, high),
                    low < high);
            }
        }
    }

    void ratios(const JsonValue& expected)
    {
        for (const JsonValue& one : expected.elements()) {
            const std::vector<JsonValue> methods = one.at("methods").elements(2);
            const double tolerance = one.at("tolerance").number(0.0, 10.0);
            for (const auto& [measure, ratio] : one.members()) {
                if (measure == "methods" || measure == "tolerance") continue;
                const double wanted = ratio.number(0.0);
                const double found = figure(methods[0].text(), measure) / figure(methods[1].text(), measure);
                const double low = wanted / (1 + tolerance), high = wanted * (1 + tolerance);
                // Not a number where both are zero: then nothing was compared.
                add(fmt::format("{}: {} has {:.3g} to {:.3g} of {}: {:.4g}", measure, methods[0].text(), low, high,
                                methods[1].text(), found),
                    found >= low && found <= high);
            }
        }
    }

    void ranges(const JsonValue& expected)
    {
        for (const auto& [method, measures] : expected.members())
            for (const auto& [measure, range] : measures.members())
                add_range(fmt::format("{} of {}", measure, method), figure(method, measure), range);
    }

    void quantities(const JsonValue& expected)
    {
        for (const auto& [quantity, range] : expected.members())
            add_range(quantity, found_.at(quantity).number(), range);
    }

private:
    double figure(const std::string& method, const std::string& measure) const
    {
        return found_.at(method).at(measure).number();
    }

    void add_range(const std::string& what, double value, const JsonValue& range)
    {
        const std::vector<double> bounds = range.numbers(2);
        add(fmt::format("{} is {:.4g} to {:.4g}: {:.4g}", what, bounds[0], bounds[1], value),
            value >= bounds[0] && value <= bounds[1]);
    }

    void add(const std::string& text, bool holds) { checks_.push_back({name_ + ", " + text, holds}); }

    std::string name_;
    JsonValue found_;
    std::vector<CheckedExpectation>& checks_;
};

}  // namespace

std::vector<CheckedExpectation> check_expectations(const std::string& tables_path, const std::string& expectations_path)
{
    const JsonValue tables(tables_path), expectations(expectations_path);
    std::vector<CheckedExpectation> checks;
    for (const auto& [name, expected] : expectations.members()) {
        if (name == "description") continue;
        TableCheck check(name, tables.at(name), checks);
        if (name == "counts") {
            check.quantities(expected);
            continue;
        }
        expected.check_keys({"order", "ratios", "ranges"});
        if (expected.has("order")) check.orders(expected.at("order"));
        if (expected.has("ratios")) check.ratios(expected.at("ratios"));
        if (expected.has("ranges")) check.ranges(expected.at("ranges"));
    }
    require_input(!checks.empty(), "{} expects nothing", expectations_path);
    return checks;
}

}  // namespace ndg
