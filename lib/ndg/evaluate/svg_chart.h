// SPDX-License-Identifier: Apache-2.0
// Line charts as SVG text, which a page can hold without a picture file.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ndg {

struct SvgLine {
    std::string name;
    std::vector<std::pair<double, double>> points;  ///< (x, y); those with y <= 0 are left out
};

/// Lines over a linear horizontal axis from `x_low` to `x_high` and a logarithmic vertical one, with a legend; "" where
/// no point can be shown.
std::string svg_chart(const std::vector<SvgLine>& lines, double x_low, double x_high, const std::string& x_axis,
                      const std::string& y_axis);

}  // namespace ndg
