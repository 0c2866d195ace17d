// SPDX-License-Identifier: Apache-2.0
// One number measured of a body, and what is published of people.
#pragma once

#include "ndg/body/person.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace ndg {

/// How a value is shown; values themselves are in metres, radians and plain numbers.
enum class MeasureUnit { millimetre, degree, number };

struct BodyMeasure {
    std::string name;
    std::string method;  ///< how it is measured, one line
    MeasureUnit unit = MeasureUnit::number;
    double value = 0.0;
    /// What is published of people like this one; infinite where nothing is.
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
    std::string source;  ///< of the range
    /// A body outside the range is wrong. Only ranges published with a spread, or asked of every body, are gates; the
    /// others are for comparison.
    bool gate = false;

    bool outside() const { return !(value >= low && value <= high); }
    /// "T4 spinous process, depth: 62.0 mm, allowed 4.4 to 28.4 mm"
    std::string failure() const;
};

/// Mean and standard deviation.
struct Spread {
    double mean, deviation;
};

/// Rows of a table of measures.
class MeasureTable {
public:
    explicit MeasureTable(const Person& person) : person_(person) {}

    /// What a row says beside its value and range.
    struct Row {
        std::string name, method;
        MeasureUnit unit = MeasureUnit::number;
        std::string source = {};
    };
    /// Nothing is published to compare with.
    void add(const Row& row, double value);
    /// For comparison.
    void add_compared(const Row& row, double value, double low, double high);
    void add_gate(const Row& row, double value, double low, double high);
    /// A gate at range().
    void add_gate(const Row& row, double value, const Spread& female, const Spread& male);
    /// The same range for comparison.
    void add_compared(const Row& row, double value, const Spread& female, const Spread& male);

    /// Three standard deviations about the mean of the person's sex, so that of 370 people one is outside; of both
    /// sexes' together where the sex is not known.
    std::pair<double, double> range(const Spread& female, const Spread& male) const;

    const std::vector<BodyMeasure>& measures() const { return measures_; }

private:
    Person person_;
    std::vector<BodyMeasure> measures_;
};

}  // namespace ndg
