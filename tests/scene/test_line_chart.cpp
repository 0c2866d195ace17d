// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/line_chart.h"

#include "ndg/core/error.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

constexpr Pixel blue = {0, 0, 250};

/// Mean row of the pixels of this colour in a column; -1 for none.
double height_of(const Image& image, int x, Pixel colour)
{
    double sum = 0;
    int count = 0;
    for (int y = 0; y < image.height; ++y)
        if (image.at(x, y) == colour) sum += y, ++count;
    return count > 0 ? sum / count : -1;
}

}  // namespace

TEST_CASE("What falls by a factor at every step is a straight line down on a logarithmic axis")
{
    ChartLine line = {"", {}, {}, blue};
    for (int i = 0; i <= 50; ++i) {
        line.x.push_back(i);
        line.y.push_back(3.0 * std::pow(0.9, i));
    }
    const Image image = line_chart({line}, {"title", "x", "y"}, 600, 400);
    std::vector<double> heights;
    for (int x = 0; x < image.width; x += 20)
        if (const double height = height_of(image, x, blue); height >= 0) heights.push_back(height);
    REQUIRE(heights.size() > 15);
    CHECK(heights.back() - heights.front() > 150);
    const double slope = (heights.back() - heights.front()) / static_cast<double>(heights.size() - 1);
    for (std::size_t i = 0; i < heights.size(); ++i)
        CHECK(heights[i] == Approx(heights.front() + slope * static_cast<double>(i)).margin(1.5));
}

TEST_CASE("A chart with one point or a constant line is drawn; what has no place on it is refused")
{
    CHECK_NOTHROW(line_chart({{"one", {1}, {0.5}, blue}}, {}));
    const Image constant = line_chart({{"", {1, 2}, {7, 7}, blue}}, {}, 600, 400);
    CHECK(height_of(constant, 300, blue) == Approx(200).margin(2));
    CHECK_THROWS_AS(line_chart({}, {}), Error);
    CHECK_THROWS_AS(line_chart({{"", {1, 2}, {1, 0}, blue}}, {}), Error);
    CHECK_THROWS_AS(line_chart({{"", {1, NAN}, {1, 1}, blue}}, {}), Error);
    CHECK_THROWS_AS(line_chart({{"", {1, 2}, {1}, blue}}, {}), Error);
}
