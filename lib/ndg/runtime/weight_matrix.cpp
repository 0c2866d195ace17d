// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/weight_matrix.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace ndg {
namespace {

constexpr std::size_t group_bytes = 64;
constexpr int most_level_of_weights = 127;
constexpr int level_offset = 1 << 15;

int columns_of_group(WeightStorage storage)
{
    return storage == WeightStorage::float32 ? 1 : storage == WeightStorage::bfloat16 ? 2 : 4;
}

std::uint32_t bits_of(float value)
{
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    return bits;
}

/// Upper half of the nearest bfloat16, ties to even. Weights are finite.
std::uint16_t to_bfloat16(float value)
{
    const std::uint32_t bits = bits_of(value);
    return static_cast<std::uint16_t>((bits + 0x7FFFU + ((bits >> 16) & 1U)) >> 16);
}

float from_bfloat16(std::uint16_t half)
{
    const std::uint32_t bits = static_cast<std::uint32_t>(half) << 16;
    float value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
}

int num_groups(WeightStorage storage, int num_columns)
{
    const int columns = columns_of_group(storage);
    return (num_columns + columns - 1) / columns;
}

}  // namespace

std::size_t weight_block_bytes(WeightStorage storage, int num_columns)
{
    const std::size_t extra = storage == WeightStorage::int8 ? 3 : 1;
    return group_bytes * (static_cast<std::size_t>(num_groups(storage, num_columns)) + extra);
}

void pack_weight_block(WeightStorage storage, int num_columns, const float* rows, const float* biases, std::byte* block)
{
    const int in_group = columns_of_group(storage), groups = num_groups(storage, num_columns);
    std::memset(block, 0, weight_block_bytes(storage, num_columns));
    float scales[weight_rows] = {};
    std::int32_t sums[weight_rows] = {};
    for (int r = 0; r < weight_rows; ++r) {
        const float* const row = rows + static_cast<std::ptrdiff_t>(r) * num_columns;
        float largest = 0;
        for (int k = 0; k < num_columns; ++k) {
            require(std::isfinite(row[k]), "a weight of the network is not finite");
            largest = std::max(largest, std::abs(row[k]));
        }
        scales[r] = largest / most_level_of_weights;
        for (int k = 0; k < num_columns; ++k) {
            const int group = k / in_group, place = k % in_group;
            std::byte* const to = block + group_bytes * static_cast<std::size_t>(group);
            if (storage == WeightStorage::float32) {
                std::memcpy(to + 4 * r, row + k, 4);
            } else if (storage == WeightStorage::bfloat16) {
                const std::uint16_t half = to_bfloat16(row[k]);
                std::memcpy(to + 4 * r + 2 * place, &half, 2);
            } else {
                const auto level = static_cast<std::int8_t>(scales[r] > 0 ? std::lround(row[k] / scales[r]) : 0);
                std::memcpy(to + 4 * r + place, &level, 1);
                sums[r] += level;
            }
        }
    }
    std::byte* const after = block + group_bytes * static_cast<std::size_t>(groups);
    std::memcpy(after, biases, sizeof(float) * weight_rows);
    if (storage != WeightStorage::int8) return;
    std::memcpy(after + group_bytes, scales, sizeof(scales));
    std::memcpy(after + 2 * group_bytes, sums, sizeof(sums));
}

bool is_finite_block(WeightStorage storage, int num_columns, const std::byte* block)
{
    const auto groups = static_cast<std::size_t>(num_groups(storage, num_columns));
    const auto value_at = [&](std::size_t word) {
        float value = 0;
        std::memcpy(&value, block + sizeof(float) * word, sizeof(float));
        return value;
    };
    const std::size_t words = group_bytes / sizeof(float);
    bool finite = true;
    for (std::size_t w = 0; w < groups * words && storage != WeightStorage::int8; ++w) {
        const std::uint32_t bits = bits_of(value_at(w));
        finite = finite && std::isfinite(value_at(w)) &&
                 (storage == WeightStorage::float32 || std::isfinite(from_bfloat16(static_cast<std::uint16_t>(bits))));
    }
    const std::size_t after = storage == WeightStorage::int8 ? 2 : 1;  // biases, scales
    for (std::size_t w = groups * words; w < (groups + after) * words; ++w)
        finite = finite && std::isfinite(value_at(w));
    return finite;
}

void PackedVector::set(const float* values, int count, WeightStorage storage)
{
    size_ = count;
    const auto groups = static_cast<std::size_t>(num_groups(storage, count));
    const std::size_t padded = groups * static_cast<std::size_t>(columns_of_group(storage));
    values_.assign(padded, 0.0F);
    std::copy_n(values, count, values_.begin());
    if (storage == WeightStorage::float32) return;
    high_.assign(groups, 0);
    low_.assign(groups, 0);
    if (storage == WeightStorage::bfloat16) {
        for (std::size_t k = 0; k < padded; ++k) {
            const std::uint16_t high = to_bfloat16(values_[k]);
            const std::uint16_t low = to_bfloat16(values_[k] - from_bfloat16(high));
            high_[k / 2] |= static_cast<std::uint32_t>(high) << (16 * (k % 2));
            low_[k / 2] |= static_cast<std::uint32_t>(low) << (16 * (k % 2));
        }
        return;
    }
    float largest = 0;
    for (const float value : values_) largest = std::max(largest, std::abs(value));
    const int most =
        std::min<std::int64_t>(std::numeric_limits<std::int16_t>::max(),
                               std::numeric_limits<std::int32_t>::max() /
                                   (static_cast<std::int64_t>(most_level_of_weights) * std::max(count, 1)));
    step_ = largest / static_cast<float>(most);
    const float levels_per_unit = largest > 0 ? static_cast<float>(most) / largest : 0.0F;
    levels_.assign(padded, 0);
    for (std::size_t k = 0; k < padded; ++k) {
        levels_[k] = static_cast<std::int16_t>(std::lround(values_[k] * levels_per_unit));
        const auto shifted = static_cast<std::uint32_t>(levels_[k] + level_offset);
        high_[k / 4] |= (shifted >> 8) << (8 * (k % 4));
        low_[k / 4] |= (shifted & 0xFFU) << (8 * (k % 4));
    }
}

const WeightKernel& find_weight_kernel(WeightStorage storage)
{
    const WeightKernel* best = nullptr;
    for (const WeightKernel& kernel : weight_kernels())
        if (kernel.storage == storage && kernel.is_available) best = &kernel;
    require(best != nullptr, "there is no product with weights as {}", to_name(storage));
    return *best;
}

}  // namespace ndg
