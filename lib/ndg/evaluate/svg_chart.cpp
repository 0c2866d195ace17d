// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr double width = 760, height = 340, left = 64, right = 220, top = 12, bottom = 44;

/// From values to pixels along one axis.
struct Axis {
    double low, high, from, to;
    double operator()(double value) const { return from + (to - from) * (value - low) / (high - low); }
};

/// Hues spread by the golden angle: neighbours in the legend differ.
std::string colour(std::size_t line)
{
    return fmt::format("hsl({:.0f} 65% 48%)", std::fmod(210.0 + 137.5 * double(line), 360.0));
}

}  // namespace

std::string svg_chart(const std::vector<SvgLine>& lines, double x_low, double x_high, const std::string& x_axis,
                      const std::string& y_axis)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const Axis x{x_low, x_high, left, width - right};
    Axis y{infinity, -infinity, height - bottom, top};
    for (const SvgLine& line : lines)
        for (const auto& [px, py] : line.points) {
            if (!(py > 0)) continue;
            y.low = std::min(y.low, std::log10(py));
            y.high = std::max(y.high, std::log10(py));
        }
    if (!(y.low <= y.high)) return "";
    y.low = std::floor(y.low);
    y.high = std::max(std::ceil(y.high), y.low + 1);

    std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\">\n", width, height);
    const auto text = [&](double at_x, double at_y, const std::string& anchor, const std::string& words) {
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", at_x, at_y, anchor, words);
    };
    for (double power = y.low; power <= y.high; ++power) {
        svg += fmt::format("<path class=\"grid\" d=\"M{} {:.1f}H{}\"/>\n", left, y(power), width - right);
        text(left - 6, y(power) + 4, "end", fmt::format("{:g}", std::pow(10.0, power)));
    }
    for (int tick = 0; tick <= 4; ++tick) {
        const double value = x.low + (x.high - x.low) * tick / 4;
        text(x(value), height - bottom + 18, "middle", fmt::format("{:.3g}", value));
    }
    text((left + width - right) / 2, height - 6, "middle", x_axis);
    svg += fmt::format("<text transform=\"translate(14 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                       (top + height - bottom) / 2, y_axis);
    for (std::size_t l = 0; l < lines.size(); ++l) {
        std::string path;
        for (const auto& [px, py] : lines[l].points)
            if (py > 0) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x(px), y(std::log10(py)));
        if (path.empty()) continue;
        const double at = top + 12 + 18 * double(l);
        svg += fmt::format("<path class=\"line\" stroke=\"{}\" d=\"{}\"/>\n", colour(l), path);
        svg += fmt::format("<path class=\"line\" stroke=\"{}\" d=\"M{} {:.1f}h18\"/>\n", colour(l), width - right + 14,
                           at - 4);
        text(width - right + 38, at, "start", lines[l].name);
    }
    return svg + "</svg>\n";
}

}  // namespace ndg
