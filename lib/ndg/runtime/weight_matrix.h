// SPDX-License-Identifier: Apache-2.0
// Matrices as they lie in memory, and in the file they are mapped from, for products with one vector: what a network
// costs a frame is to read them once from beginning to end.
#pragma once

#include "ndg/core/enum_names.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ndg {

/// float32: as trained. bfloat16: the same with eight bits of mantissa. int8: whole numbers times a scale of each row.
enum class WeightStorage { float32, bfloat16, int8 };
template <>
inline constexpr EnumName<WeightStorage> enum_table<WeightStorage>[] = {
    {WeightStorage::float32, "float32"}, {WeightStorage::bfloat16, "bfloat16"}, {WeightStorage::int8, "int8"}};

/// Rows that lie side by side, one a lane.
constexpr int weight_rows = 16;

/// Blocks of weight_rows rows, each of them groups of 64 bytes: in a group every row has its next column (float32), its
/// next two (bfloat16) or four (int8). After the groups stand 64 bytes of biases; of int8 also 64 of scales and 64 of
/// the sums of each row's whole numbers. Rows are never apart by a power of two: a block is one stream of memory.
std::size_t weight_block_bytes(WeightStorage storage, int num_columns);
inline int num_weight_blocks(int num_rows)
{
    return (num_rows + weight_rows - 1) / weight_rows;
}

/// Packs weight_rows rows (row-major, float32) and their biases into one block. int8: row r is rounded to 127 steps of
/// its largest value on each side, an error of at most half a step a weight.
void pack_weight_block(WeightStorage storage, int num_columns, const float* rows, const float* biases,
                       std::byte* block);
/// Whether the weights, scales and biases of a block are finite.
bool is_finite_block(WeightStorage storage, int num_columns, const std::byte* block);

/// A vector, ready to be multiplied.
class PackedVector {
public:
    /// For matrices of this storage. int8: rounded to 16 bits, or as many fewer as keep sums of `count` products with
    /// 8 bits within 32.
    void set(const float* values, int count, WeightStorage storage);

    int size() const { return size_; }
    const float* values() const { return values_.data(); }            ///< float32, bfloat16
    const std::uint32_t* high_pairs() const { return high_.data(); }  ///< bfloat16: pairs of upper halves
    const std::uint32_t* low_pairs() const { return low_.data(); }    ///< bfloat16: what the upper halves leave
    const std::int16_t* levels() const { return levels_.data(); }     ///< int8: values = step() times levels
    const std::uint32_t* high_bytes() const { return high_.data(); }  ///< int8: of four levels + 2^15, the upper bytes
    const std::uint32_t* low_bytes() const { return low_.data(); }    ///< and the lower ones
    float step() const { return step_; }

private:
    int size_ = 0;
    float step_ = 0;
    std::vector<float> values_;
    std::vector<std::int16_t> levels_;
    std::vector<std::uint32_t> high_, low_;
};

/// One way to multiply matrices of one storage, with the instructions of some processors.
struct WeightKernel {
    const char* name;
    WeightStorage storage;
    bool is_available;
    /// results[r] = bias_r + sum_k weight_rk input_k for the rows of `num_blocks` blocks that follow each other.
    void (*multiply)(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results);
};

/// All there are, also those that this processor does not have; of each storage the fastest one last.
const std::vector<WeightKernel>& weight_kernels();
/// The fastest one that is available.
const WeightKernel& find_weight_kernel(WeightStorage storage);

}  // namespace ndg
