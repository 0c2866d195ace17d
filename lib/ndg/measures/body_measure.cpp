// SPDX-License-Identifier: Apache-2.0
#include "ndg/measures/body_measure.h"

#include "ndg/measures/measure_report.h"

#include <fmt/format.h>

#include <algorithm>

namespace ndg {
std::string BodyMeasure::failure() const
{
    return fmt::format("{}: {}, allowed {}", name, measure_text(value, unit), range_text(*this));
}

std::pair<double, double> MeasureTable::range(const Spread& female, const Spread& male) const
{
    constexpr double deviations = 3.0;
    const bool is_female = person_.sex<0.75, is_male = person_.sex> 0.25;
    const double inf = std::numeric_limits<double>::infinity();
    return {std::min(is_female ? female.mean - deviations * female.deviation : inf,
                     is_male ? male.mean - deviations * male.deviation : inf),
            std::max(is_female ? female.mean + deviations * female.deviation : -inf,
                     is_male ? male.mean + deviations * male.deviation : -inf)};
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
    const auto [low, high] = range(female, male);
    add_gate(row, value, low, high);
}

void MeasureTable::add_compared(const Row& row, double value, const Spread& female, const Spread& male)
{
    const auto [low, high] = range(female, male);
    add_compared(row, value, low, high);
}

}  // namespace ndg
