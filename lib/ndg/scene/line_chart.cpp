// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/line_chart.h"

#include "ndg/core/error.h"
#include "ndg/scene/text.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

constexpr int text_scale = 2, left = 110, right = 30, top = 70, bottom = 70, gap = 8;
constexpr double half_width = 1.2;  ///< of a line, pixels
constexpr Pixel ink = {40, 40, 40}, grid = {225, 225, 225};

/// From coordinates to pixels along one axis.
struct Axis {
    double low = 0, high = 1;
    int from = 0, to = 1;  ///< pixels

    double pixel(double value) const { return from + (to - from) * (value - low) / (high - low); }
};

void draw_segment(Image& image, const Eigen::Vector2d& a, const Eigen::Vector2d& b, Pixel colour)
{
    const Eigen::Vector2d low = a.cwiseMin(b).array() - 2, high = a.cwiseMax(b).array() + 2, along = b - a;
    const double squared_length = std::max(along.squaredNorm(), 1e-12);
    for (int y = std::max(0, int(low.y())); y <= std::min(image.height - 1, int(high.y())); ++y)
        for (int x = std::max(0, int(low.x())); x <= std::min(image.width - 1, int(high.x())); ++x) {
            const Eigen::Vector2d point(x, y);
            const double t = std::clamp((point - a).dot(along) / squared_length, 0.0, 1.0);
            const double cover = std::clamp(half_width + 0.5 - (point - a - t * along).norm(), 0.0, 1.0);
            Pixel& pixel = image.at(x, y);
            for (std::size_t c = 0; c < 3; ++c)
                pixel[c] = std::uint8_t(std::lround(pixel[c] + cover * (double(colour[c]) - double(pixel[c]))));
        }
}

/// Multiples of 1, 2 or 5 times a power of ten, about `count` of them.
std::vector<double> even_ticks(double low, double high, int count)
{
    const double rough = std::max(high - low, 1e-12) / count, power = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = power * (rough > 5 * power ? 10 : rough > 2 * power ? 5 : rough > power ? 2 : 1);
    std::vector<double> ticks;
    for (double tick = std::ceil(low / step) * step; tick <= high + 1e-9 * step; tick += step) ticks.push_back(tick);
    return ticks;
}

/// 1, 2 and 5 times powers of ten within these logarithms; all nine multiples where that leaves few.
std::vector<double> logarithmic_ticks(double low, double high)
{
    std::vector<double> ticks;
    for (int power = int(std::floor(low)); power <= int(std::ceil(high)); ++power)
        for (const int factor : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
            const double value = std::log10(factor) + power;
            if (high - low > 0.7 && factor != 1 && factor != 2 && factor != 5) continue;
            if (value >= low && value <= high) ticks.push_back(value);
        }
    return ticks;
}

void draw_axes(Image& image, const Axis& x_axis, const Axis& y_axis, const ChartLabels& labels)
{
    const int text_y = text_height(text_scale);
    for (const double tick : even_ticks(x_axis.low, x_axis.high, 10)) {
        const int x = int(std::lround(x_axis.pixel(tick)));
        for (int y = y_axis.to; y <= y_axis.from; ++y) image.at(x, y) = grid;
        const std::string text = fmt::format("{:g}", tick);
        draw_text(image, text, x - text_width(text, text_scale) / 2, y_axis.from + gap, text_scale, ink);
    }
    for (const double tick : logarithmic_ticks(y_axis.low, y_axis.high)) {
        const int y = int(std::lround(y_axis.pixel(tick)));
        for (int x = x_axis.from; x <= x_axis.to; ++x) image.at(x, y) = grid;
        const std::string text = fmt::format("{:.0e}", std::pow(10.0, tick));
        draw_text(image, text, x_axis.from - gap - text_width(text, text_scale), y - text_y / 2, text_scale, ink);
    }
    for (int x = x_axis.from; x <= x_axis.to; ++x) image.at(x, y_axis.from) = ink;
    for (int y = y_axis.to; y <= y_axis.from; ++y) image.at(x_axis.from, y) = ink;
    draw_text(image, labels.title, gap, gap, text_scale, ink);
    draw_text(image, labels.y_axis, gap, top - gap - text_y, text_scale, ink);
    draw_text(image, labels.x_axis, x_axis.to - text_width(labels.x_axis, text_scale), y_axis.from + 2 * gap + text_y,
              text_scale, ink);
}

}  // namespace

Image line_chart(const std::vector<ChartLine>& lines, const ChartLabels& labels, int width, int height)
{
    double low_x = INFINITY, high_x = -INFINITY, low_y = INFINITY, high_y = -INFINITY;
    for (const ChartLine& line : lines) {
        require(line.x.size() == line.y.size(), "the line {} has {} x and {} y", line.name, line.x.size(),
                line.y.size());
        for (std::size_t i = 0; i < line.x.size(); ++i) {
            require(std::isfinite(line.x[i]) && std::isfinite(line.y[i]) && line.y[i] > 0,
                    "the line {} goes through ({}, {})", line.name, line.x[i], line.y[i]);
            low_x = std::min(low_x, line.x[i]);
            high_x = std::max(high_x, line.x[i]);
            low_y = std::min(low_y, std::log10(line.y[i]));
            high_y = std::max(high_y, std::log10(line.y[i]));
        }
    }
    require(low_x <= high_x, "a chart without points");
    require(width >= 300 && height >= 200, "a chart of {} x {} pixels", width, height);
    if (high_x == low_x) high_x += 1;
    const double margin = std::max(0.02, 0.04 * (high_y - low_y));
    Image image(width, height);
    const Axis x_axis{low_x, high_x, left, width - right};
    const Axis y_axis{low_y - margin, high_y + margin, height - bottom, top};
    draw_axes(image, x_axis, y_axis, labels);
    int legend_x = width - right;
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
        legend_x -= text_width(line->name, text_scale);
        draw_text(image, line->name, legend_x, top - gap - text_height(text_scale), text_scale, line->colour);
        legend_x -= 3 * gap;
    }
    for (const ChartLine& line : lines)
        for (std::size_t i = 0; i < line.x.size(); ++i) {
            const auto point = [&](std::size_t k) {
                return Eigen::Vector2d(x_axis.pixel(line.x[k]), y_axis.pixel(std::log10(line.y[k])));
            };
            draw_segment(image, point(i > 0 ? i - 1 : 0), point(i), line.colour);
        }
    return image;
}

}  // namespace ndg
