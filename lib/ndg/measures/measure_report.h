// SPDX-License-Identifier: Apache-2.0
// Measures as text.
#pragma once

#include "ndg/measures/body_measures.h"

#include <string>
#include <vector>

namespace ndg {

/// "62.0 mm", "41.3 degrees", "0.234".
std::string measure_text(double value, MeasureUnit unit);
/// "4.4 to 28.4 mm", "at most 12.0 mm"; empty for a measure without a range.
std::string range_text(const BodyMeasure& measure);

/// All bodies, then the statistics of several.
std::string measures_report(const std::vector<MeasuredBody>& bodies);
/// One line a measure: name, value, published range and, outside of it, whether a gate is missed; with `explained` also
/// how it is measured and the source of the range.
std::string body_report(const MeasuredBody& body, bool explained);
/// Over all bodies, one line a measure: mean, standard deviation, least and greatest value, how many are outside the
/// published range, how it is measured and the source of the range.
std::string statistics_report(const std::vector<MeasuredBody>& bodies);
/// Bodies that miss a gate with what they miss, then the gates over all bodies that do not hold; empty when all hold.
std::string failure_report(const std::vector<MeasuredBody>& bodies);

}  // namespace ndg
