// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"

#include "ndg/core/error.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

using namespace ndg;

TEST_CASE("SplitMix64 in counter mode: same key, same values")
{
    Random a(1, "bodies", 3), b(1, "bodies", 3);
    for (int i = 0; i < 100; ++i) CHECK(a.next() == b.next());
    // Literal values: a change would silently change every data set made from a seed.
    Random fixed(42, "pairs", 0);
    CHECK(fixed.next() == 4771547509553472113ULL);
    CHECK(fixed.next() == 15126395162934161568ULL);
}

TEST_CASE("seed, stream and index all change the values, and samples do not depend on order")
{
    std::set<std::uint64_t> firsts;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        for (const char* stream : {"bodies", "pairs", "poses", ""}) {
            for (std::uint64_t index = 0; index < 100; ++index) firsts.insert(Random(seed, stream, index).next());
        }
    }
    CHECK(firsts.size() == 10 * 4 * 100);

    std::vector<double> forward(20), backward(20);
    for (std::size_t i = 0; i < 20; ++i) forward[i] = Random(5, "x", i).normal();
    for (std::size_t i = 20; i-- > 0;) backward[i] = Random(5, "x", i).normal();
    CHECK(forward == backward);
}

TEST_CASE("uniform: range, mean and variance, within one stream and across indices")
{
    constexpr int count = 200000;
    for (const bool across : {false, true}) {
        double sum = 0, sum_squares = 0, low = 1, high = 0;
        Random stream(9, "u");
        for (int i = 0; i < count; ++i) {
            const double value = across ? Random(9, "u", static_cast<std::uint64_t>(i)).uniform() : stream.uniform();
            sum += value;
            sum_squares += value * value;
            low = std::min(low, value);
            high = std::max(high, value);
        }
        const double mean = sum / count;
        // Five standard errors: sqrt(1 / 12 / n) and sqrt(1 / 180 / n).
        CHECK(mean == Approx(0.5).margin(5 * std::sqrt(1.0 / 12 / count)));
        CHECK(sum_squares / count - mean * mean == Approx(1.0 / 12).margin(5 * std::sqrt(1.0 / 180 / count)));
        CHECK(low >= 0.0);
        CHECK(high < 1.0);
    }
    Random stream(1, "range");
    for (int i = 0; i < 1000; ++i) {
        const double value = stream.uniform(-2.0, 3.0);
        CHECK((value >= -2.0 && value < 3.0));
    }
}

TEST_CASE("normal: mean, variance, kurtosis and independence of neighbours")
{
    constexpr int count = 200000;
    Random stream(3, "n");
    double sum = 0, sum_squares = 0, sum_fourths = 0, sum_products = 0, previous = 0;
    for (int i = 0; i < count; ++i) {
        const double value = stream.normal();
        sum += value;
        sum_squares += value * value;
        sum_fourths += value * value * value * value;
        sum_products += value * previous;
        previous = value;
    }
    const double n = count;
    CHECK(sum / n == Approx(0.0).margin(5 / std::sqrt(n)));
    CHECK(sum_squares / n == Approx(1.0).margin(5 * std::sqrt(2 / n)));
    CHECK(sum_fourths / n == Approx(3.0).margin(5 * std::sqrt(96 / n)));
    CHECK(sum_products / n == Approx(0.0).margin(5 / std::sqrt(n)));
}

TEST_CASE("below: every value equally often")
{
    Random stream(4, "below");
    std::vector<int> counts(7, 0);
    constexpr int count = 70000;
    for (int i = 0; i < count; ++i) ++counts.at(stream.below(7));
    for (const int hits : counts) CHECK(hits == Approx(10000).margin(5 * std::sqrt(10000.0)));
    CHECK(stream.below(1) == 0);
    CHECK_THROWS_AS(stream.below(0), Error);
}

TEST_CASE("permutation: complete, reproducible, every place equally likely")
{
    const std::vector<int> order = Random(1, "p").permutation(50);
    CHECK(order == Random(1, "p").permutation(50));
    std::vector<int> sorted = order, identity(50);
    std::iota(identity.begin(), identity.end(), 0);
    CHECK(order != identity);
    std::sort(sorted.begin(), sorted.end());
    CHECK(sorted == identity);
    CHECK(Random(1, "p").permutation(0).empty());

    int counts[3][3] = {};
    constexpr int count = 9000;
    for (int i = 0; i < count; ++i) {
        const auto small = Random(2, "p", static_cast<std::uint64_t>(i)).permutation(3);
        for (int place = 0; place < 3; ++place) ++counts[place][small[place]];
    }
    for (const auto& row : counts) {
        for (const int hits : row) CHECK(hits == Approx(3000).margin(5 * std::sqrt(2000.0)));
    }
}
