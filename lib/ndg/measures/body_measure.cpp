// SPDX-License-Identifier: Apache-2.0
#include "ndg/measures/body_measure.h"

#include "ndg/measures/measure_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace ndg {
namespace {

constexpr double deviations = 3.0;  ///< of a gate, so that of 370 people one is outside

/// Three deviations about the mean, of one sex or both.
std::pair<double, double> range(const Person& person, const Spread& female, const Spread& male)
{
    const bool is_female = person.sex<0.75, is_male = person.sex> 0.25;
    const double inf = std::numeric_limits<double>::infinity();
    return {std::min(is_female ? female.mean - deviations * female.deviation : inf,
                     is_male ? male.mean - deviations * male.deviation : inf),
            std::max(is_female ? female.mean + deviations * female.deviation : -inf,
                     is_male ? male.mean + deviations * male.deviation : -inf)};
}

}  // namespace

std::string BodyMeasure::failure() const
{
    return fmt::format("{}: {}, allowed {}", name, measure_text(value, unit), range_text(*this));
}

void MeasureTable::add(const Row& row, double value)
{
    BodyMeasure measure;
    measure.name = row.name;
    measure.method = row.method;
    measure.unit = row.unit;
    measure.value = value;
    measure.source = row.source;
    measures_.push_back(measure);
}

void MeasureTable::add_compared(const Row& row, double value, double low, double high)
{
    add(row, value);
    measures_.back().low = low;
    measures_.back().high = high;
}

void MeasureTable::add_gate(const Row& row, double value, double low, double high)
{
    add_compared(row, value, low, high);
    measures_.back().gate = true;
}

void MeasureTable::add_gate(const Row& row, double value, const Spread& female, const Spread& male)
{
    const auto [low, high] = range(person_, female, male);
    add_gate(row, value, low, high);
}

void MeasureTable::add_compared(const Row& row, double value, const Spread& female, const Spread& male)
{
    const auto [low, high] = range(person_, female, male);
    add_compared(row, value, low, high);
}

}  // namespace ndg
