// SPDX-License-Identifier: Apache-2.0
#include "ndg/placement/interpolation.h"

#include <algorithm>
#include <cstddef>

namespace ndg {

double interpolate(const std::vector<double>& knots, const std::vector<double>& values, double x)
{
    if (x <= knots.front()) return values.front();
    if (x >= knots.back()) return values.back();
    const auto next = static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin());
    const double share = (x - knots[next - 1]) / (knots[next] - knots[next - 1]);
    return (1.0 - share) * values[next - 1] + share * values[next];
}

double interpolate_monotone(const std::vector<double>& knots, const std::vector<double>& values, double x)
{
    const std::size_t last = knots.size() - 1;
    const auto secant = [&](std::size_t k) { return (values[k + 1] - values[k]) / (knots[k + 1] - knots[k]); };
    const auto slope = [&](std::size_t k) {
        if (k == 0 || k == last) return secant(k == 0 ? 0 : last - 1);
        const double before = secant(k - 1), after = secant(k);
        return before * after <= 0.0 ? 0.0 : 2.0 * before * after / (before + after);
    };
    if (x <= knots.front()) return values.front() + slope(0) * (x - knots.front());
    if (x >= knots.back()) return values.back() + slope(last) * (x - knots.back());
    const auto k = static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin()) - 1;
    const double length = knots[k + 1] - knots[k], t = (x - knots[k]) / length;
    return (1 + 2 * t) * (1 - t) * (1 - t) * values[k] + t * (1 - t) * (1 - t) * length * slope(k) +
           t * t * (3 - 2 * t) * values[k + 1] + t * t * (t - 1) * length * slope(k + 1);
}

double smoothstep(double begin, double end, double x)
{
    const double t = std::clamp((x - begin) / (end - begin), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

}  // namespace ndg
