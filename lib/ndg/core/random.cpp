// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"

#include "ndg/core/error.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace ndg {
namespace {

constexpr std::uint64_t golden_gamma = 0x9e3779b97f4a7c15ULL;

/// Output function of SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t mix(std::uint64_t value)
{
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
    return value ^ (value >> 31);
}

/// FNV-1a, 64 bits.
std::uint64_t hash_name(std::string_view name)
{
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return hash;
}

}  // namespace

Random::Random(std::uint64_t seed, std::string_view stream, std::uint64_t index)
    : key_(mix(mix(mix(seed + golden_gamma) ^ hash_name(stream)) + golden_gamma * (index + 1)))
{
}

std::uint64_t Random::next()
{
    return mix(key_ + golden_gamma * ++counter_);
}

double Random::uniform()
{
    return static_cast<double>(next() >> 11) * 0x1.0p-53;
}

double Random::uniform(double low, double high)
{
    const double value = low + (high - low) * uniform();
    // Rounding may reach `high`, which is excluded.
    return value < high ? value : std::nextafter(high, low);
}

std::uint64_t Random::below(std::uint64_t count)
{
    require(count > 0, "Random::below needs a positive count");
    // Values beyond the last full multiple of count would favour small results.
    const std::uint64_t max = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t limit = max - max % count;
    std::uint64_t value = next();
    while (value >= limit) value = next();
    return value % count;
}

double Random::normal()
{
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * 3.14159265358979323846 * uniform();
    return radius * std::cos(angle);
}

std::vector<int> Random::permutation(int count)
{
    require(count >= 0, "Random::permutation needs a count >= 0, got {}", count);
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[below(i)]);
    return order;
}

}  // namespace ndg
