// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/half_rows.h"

#include <Eigen/Core>

#include <algorithm>
#include <utility>

namespace ndg {
namespace {

float value_of(std::uint16_t bits, float origin)
{
    return origin + static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
}

}  // namespace

HalfRows::HalfRows(std::vector<float> origin, int num_rows, double max_bytes)
    : origin_(std::move(origin)), rows_(num_rows), states_(num_rows)
{
    const double row_bytes = std::max(1.0, bytes_of(1, origin_.size()));
    room_ = static_cast<std::int64_t>(std::min(static_cast<double>(num_rows), max_bytes / row_bytes));
}

bool HalfRows::read(int row, float* values) const
{
    if (states_[row].load(std::memory_order_acquire) != kept) return false;
    const std::uint16_t* bits = rows_[row].get();
    for (std::size_t k = 0; k < origin_.size(); ++k) values[k] = value_of(bits[k], origin_[k]);
    return true;
}

bool HalfRows::keep(int row, float* values)
{
    std::uint8_t expected = missing;
    std::uint16_t* bits = nullptr;
    if (room_ > 0 && states_[row].compare_exchange_strong(expected, being_written)) {
        if (room_.fetch_sub(1) > 0) {
            rows_[row] = std::make_unique<std::uint16_t[]>(origin_.size());
            bits = rows_[row].get();
        } else {
            states_[row] = missing;
        }
    }
    for (std::size_t k = 0; k < origin_.size(); ++k) {
        const auto rounded = Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(values[k] - origin_[k]));
        if (bits) bits[k] = rounded;
        values[k] = value_of(rounded, origin_[k]);
    }
    if (bits) states_[row].store(kept, std::memory_order_release);
    return bits != nullptr;
}

}  // namespace ndg
