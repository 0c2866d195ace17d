// SPDX-License-Identifier: Apache-2.0
// Rows of float16 up to a bound of memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace ndg {

/// Rows of numbers near an origin, as float16 differences from it: rounded by at most 2^-11 of the difference
/// (3e-8 where that is below 6e-5, infinite beyond 65504). For several threads at once.
class HalfRows {
public:
    /// At most `max_bytes` of rows are kept.
    HalfRows(std::vector<float> origin, int num_rows, double max_bytes);

    /// False where the row is not kept.
    bool read(int row, float* values) const;
    /// Rounds the values to what read gives, whether there is room to keep them or not. True when this call kept them.
    bool keep(int row, float* values);
    static double bytes_of(int num_rows, std::size_t width) { return 2.0 * num_rows * static_cast<double>(width); }

private:
    enum State : std::uint8_t { missing, being_written, kept };

    std::vector<float> origin_;
    std::vector<std::unique_ptr<std::uint16_t[]>> rows_;
    std::vector<std::atomic<std::uint8_t>> states_;
    std::atomic<std::int64_t> room_;  ///< rows that may still be kept
};

}  // namespace ndg
