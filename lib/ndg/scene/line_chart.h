// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/image.h"

#include <string>
#include <vector>

namespace ndg {

/// A line of points (x, y), all finite, as many of one as of the other.
struct ChartLine {
    std::string name;
    std::vector<double> x, y;
    Pixel colour = {0, 0, 0};
};

struct ChartLabels {
    std::string title, x_axis, y_axis;
};

/// Lines over two axes, the vertical one logarithmic, with a grid, numbers along it and names of the lines. Throws
/// Error where there is no point, where coordinates are not finite or where a y is not positive.
Image line_chart(const std::vector<ChartLine>& lines, const ChartLabels& labels, int width = 960, int height = 600);

}  // namespace ndg
