// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers: the value depends on (seed, stream, index) alone, never on the order of calls
// between samples, so results do not depend on threads or shards.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace ndg {

class Random {
public:
    /// `stream` names what is drawn ("bodies", "pairs"...), `index` the sample.
    Random(std::uint64_t seed, std::string_view stream, std::uint64_t index = 0);

    std::uint64_t next();
    /// Uniform in [0, 1).
    double uniform();
    /// Uniform in [low, high).
    double uniform(double low, double high);
    /// Uniform integer in [0, count), count > 0, without modulo bias.
    std::uint64_t below(std::uint64_t count);
    /// Standard normal (Box-Muller, no state carried between calls).
    double normal();
    /// 0..count-1 in random order (Fisher-Yates).
    std::vector<int> permutation(int count);

private:
    std::uint64_t key_;
    std::uint64_t counter_ = 0;
};

}  // namespace ndg
