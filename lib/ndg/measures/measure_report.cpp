// SPDX-License-Identifier: Apache-2.0
#include "ndg/measures/measure_report.h"

#include "ndg/core/angles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace ndg {
namespace {

constexpr double mm = 1e3;

std::string number_text(double value, MeasureUnit unit)
{
    if (unit == MeasureUnit::millimetre) return fmt::format("{:.1f}", mm * value);
    if (unit == MeasureUnit::degree) return fmt::format("{:.1f}", value / radians_per_degree);
    return fmt::format("{:.3f}", value);
}

std::string unit_text(MeasureUnit unit)
{
    return unit == MeasureUnit::millimetre ? " mm" : unit == MeasureUnit::degree ? " degrees" : "";
}

/// Values of one measure over the bodies.
struct Values {
    BodyMeasure last;
    std::vector<double> values;
    int outside = 0;
};

}  // namespace

std::string measure_text(double value, MeasureUnit unit)
{
    return number_text(value, unit) + unit_text(unit);
}

std::string range_text(const BodyMeasure& measure)
{
    const bool low = std::isfinite(measure.low), high = std::isfinite(measure.high);
    if (!low && !high) return {};
    if (!low) return "at most " + measure_text(measure.high, measure.unit);
    if (!high) return "at least " + measure_text(measure.low, measure.unit);
    return number_text(measure.low, measure.unit) + " to " + measure_text(measure.high, measure.unit);
}

std::string measures_report(const std::vector<MeasuredBody>& bodies)
{
    std::string text;
    for (const MeasuredBody& body : bodies) text += body_report(body, bodies.size() == 1);
    return bodies.size() > 1 ? text + statistics_report(bodies) : text;
}

std::string body_report(const MeasuredBody& body, bool explained)
{
    const char* sex = body.person.sex < 0.25 ? "woman" : body.person.sex > 0.75 ? "man" : "sex unknown";
    std::string text =
        fmt::format("body {}: {}, stature {:.3f} m, BMI {:.1f}\n", body.name, sex, body.stature_m, body.bmi);
    for (const BodyMeasure& measure : body.measures) {
        const char* verdict = !measure.outside() ? "" : measure.gate ? "OUTSIDE THE GATE" : "outside, no gate";
        text += fmt::format("  {:<40} {:>13}   {:<22} {:<16}", measure.name, measure_text(measure.value, measure.unit),
                            range_text(measure), verdict);
        if (explained)
            text += fmt::format("  {}{}{}", measure.method, measure.source.empty() ? "" : "; ", measure.source);
        text += "\n";
    }
    return text;
}

std::string statistics_report(const std::vector<MeasuredBody>& bodies)
{
    std::vector<std::string> order;
    std::map<std::string, Values> all;
    for (const MeasuredBody& body : bodies)
        for (const BodyMeasure& measure : body.measures) {
            Values& values = all[measure.name];
            if (values.values.empty()) order.push_back(measure.name);
            values.last = measure;
            values.values.push_back(measure.value);
            values.outside += measure.outside();
        }
    std::string text = fmt::format("{} bodies\n{:<44} {:>8} {:>8} {:>8} {:>8} {:>8}  {}\n", bodies.size(), "measure",
                                   "mean", "sd", "min", "max", "outside", "how measured; published");
    for (const std::string& name : order) {
        const Values& values = all.at(name);
        const Eigen::Map<const Eigen::VectorXd> v(values.values.data(), Eigen::Index(values.values.size()));
        const double deviation =
            v.size() < 2 ? 0.0 : std::sqrt((v.array() - v.mean()).square().sum() / double(v.size() - 1));
        const MeasureUnit unit = values.last.unit;
        const std::string counted = range_text(values.last).empty() ? "" : fmt::format("{}", values.outside);
        text += fmt::format("{:<44} {:>8} {:>8} {:>8} {:>8} {:>7}{}  {}{}{}\n", name + unit_text(unit),
                            number_text(v.mean(), unit), number_text(deviation, unit), number_text(v.minCoeff(), unit),
                            number_text(v.maxCoeff(), unit), counted, values.last.gate ? "!" : " ", values.last.method,
                            values.last.source.empty() ? "" : "; ", values.last.source);
    }
    return text + "(!: a gate; other ranges are for comparison)\n";
}

std::string failure_report(const std::vector<MeasuredBody>& bodies)
{
    std::string text;
    for (const MeasuredBody& body : bodies) {
        const std::vector<std::string> failures = body.failures();
        if (!failures.empty()) text += fmt::format("body {} is outside: {}\n", body.name, fmt::join(failures, "; "));
    }
    for (const std::string& sentence : common_failures(bodies)) text += sentence + "\n";
    return text;
}

}  // namespace ndg
