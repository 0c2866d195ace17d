// SPDX-License-Identifier: Apache-2.0
// The kernels of weight_matrix.h. Those of int8 add whole numbers and agree to the last bit; those of float32 and
// bfloat16 add in different orders.
#include "ndg/runtime/weight_matrix.h"

#include <cstring>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace ndg {
namespace {

constexpr int group_bytes = 64;

// For every processor: loops over the lanes of a group.

struct Lanes {
    float values[weight_rows] = {};
};

template <typename T>
Lanes lanes_at(const std::byte* from)
{
    T values[weight_rows];
    std::memcpy(values, from, sizeof(values));
    Lanes lanes;
    for (int r = 0; r < weight_rows; ++r) lanes.values[r] = static_cast<float>(values[r]);
    return lanes;
}

void multiply_float32(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results)
{
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        Lanes sums;
        for (int k = 0; k < input.size(); ++k, blocks += group_bytes) {
            const Lanes weights = lanes_at<float>(blocks);
            for (int r = 0; r < weight_rows; ++r) sums.values[r] += weights.values[r] * input.values()[k];
        }
        const Lanes biases = lanes_at<float>(blocks);
        for (int r = 0; r < weight_rows; ++r) results[r] = sums.values[r] + biases.values[r];
        blocks += group_bytes;
    }
}

void multiply_bfloat16(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results)
{
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        Lanes sums;
        for (int k = 0; k < input.size(); k += 2, blocks += group_bytes) {
            std::uint32_t pairs[weight_rows];
            std::memcpy(pairs, blocks, sizeof(pairs));
            for (int r = 0; r < weight_rows; ++r) {
                const std::uint32_t even = pairs[r] << 16, odd = pairs[r] & 0xFFFF0000U;
                float values[2];
                std::memcpy(values, &even, 4);
                std::memcpy(values + 1, &odd, 4);
                sums.values[r] += values[0] * input.values()[k] + values[1] * input.values()[k + 1];
            }
        }
        const Lanes biases = lanes_at<float>(blocks);
        for (int r = 0; r < weight_rows; ++r) results[r] = sums.values[r] + biases.values[r];
        blocks += group_bytes;
    }
}

void multiply_int8(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results)
{
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        std::int32_t sums[weight_rows] = {};
        for (int k = 0; k < input.size(); k += 4, blocks += group_bytes) {
            std::int8_t weights[4 * weight_rows];
            std::memcpy(weights, blocks, sizeof(weights));
            for (int r = 0; r < weight_rows; ++r)
                for (int c = 0; c < 4; ++c) sums[r] += weights[4 * r + c] * input.levels()[k + c];
        }
        const Lanes biases = lanes_at<float>(blocks), scales = lanes_at<float>(blocks + group_bytes);
        for (int r = 0; r < weight_rows; ++r)
            results[r] = biases.values[r] + scales.values[r] * input.step() * static_cast<float>(sums[r]);
        blocks += 3 * group_bytes;
    }
}

#ifdef __x86_64__

/// Bytes that memory is asked for ahead: the processor's own prefetchers stop at the end of a page.
constexpr int ahead = 4096;

inline void prefetch(const std::byte* from)
{
    _mm_prefetch(reinterpret_cast<const char*>(from + ahead), _MM_HINT_T0);
}

#define NDG_AVX2 __attribute__((target("avx2,fma")))
#define NDG_AVX512 __attribute__((target("avx512f")))
#define NDG_AVX512_BF16 __attribute__((target("avx512f,avx512bf16")))
#define NDG_AVX512_VNNI __attribute__((target("avx512f,avx512bw,avx512vnni")))

NDG_AVX2 inline __m256 floats_at(const std::byte* from)
{
    return _mm256_loadu_ps(reinterpret_cast<const float*>(from));
}

NDG_AVX2 inline __m256i integers_at(const std::byte* from)
{
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}

NDG_AVX512 inline __m512 wide_floats_at(const std::byte* from)
{
    return _mm512_loadu_ps(from);
}

NDG_AVX512 inline __m512i wide_integers_at(const std::byte* from)
{
    return _mm512_loadu_si512(from);
}

NDG_AVX2 void multiply_float32_avx2(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results)
{
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m256 low = _mm256_setzero_ps(), high = low;
        for (int k = 0; k < input.size(); ++k, blocks += group_bytes) {
            prefetch(blocks);
            const __m256 x = _mm256_broadcast_ss(input.values() + k);
            low = _mm256_fmadd_ps(floats_at(blocks), x, low);
            high = _mm256_fmadd_ps(floats_at(blocks + 32), x, high);
        }
        _mm256_storeu_ps(results, _mm256_add_ps(low, floats_at(blocks)));
        _mm256_storeu_ps(results + 8, _mm256_add_ps(high, floats_at(blocks + 32)));
        blocks += group_bytes;
    }
}

NDG_AVX512 void multiply_float32_avx512(const PackedVector& input, const std::byte* blocks, int num_blocks,
                                        float* results)
{
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m512 even = _mm512_setzero_ps(), odd = even;
        int k = 0;
        for (; k + 1 < input.size(); k += 2, blocks += 2 * group_bytes) {
            prefetch(blocks);
            prefetch(blocks + group_bytes);
            even = _mm512_fmadd_ps(wide_floats_at(blocks), _mm512_set1_ps(input.values()[k]), even);
            odd = _mm512_fmadd_ps(wide_floats_at(blocks + group_bytes), _mm512_set1_ps(input.values()[k + 1]), odd);
        }
        for (; k < input.size(); ++k, blocks += group_bytes)
            even = _mm512_fmadd_ps(wide_floats_at(blocks), _mm512_set1_ps(input.values()[k]), even);
        _mm512_storeu_ps(results, _mm512_add_ps(_mm512_add_ps(even, odd), wide_floats_at(blocks)));
        blocks += group_bytes;
    }
}

NDG_AVX2 void multiply_bfloat16_avx2(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results)
{
    const __m256i upper = _mm256_set1_epi32(static_cast<int>(0xFFFF0000U));
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m256 sums[4] = {_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()};
        for (int k = 0; k < input.size(); k += 2, blocks += group_bytes) {
            prefetch(blocks);
            const __m256 first = _mm256_broadcast_ss(input.values() + k);
            const __m256 second = _mm256_broadcast_ss(input.values() + k + 1);
            for (int half = 0; half < 2; ++half) {
                const __m256i pairs = integers_at(blocks + 32 * half);
                const __m256 even = _mm256_castsi256_ps(_mm256_slli_epi32(pairs, 16));
                const __m256 odd = _mm256_castsi256_ps(_mm256_and_si256(pairs, upper));
                sums[half] = _mm256_fmadd_ps(even, first, sums[half]);
                sums[2 + half] = _mm256_fmadd_ps(odd, second, sums[2 + half]);
            }
        }
        for (int half = 0; half < 2; ++half)
            _mm256_storeu_ps(results + 8 * half,
                             _mm256_add_ps(_mm256_add_ps(sums[half], sums[2 + half]), floats_at(blocks + 32 * half)));
        blocks += group_bytes;
    }
}

NDG_AVX512 void multiply_bfloat16_avx512(const PackedVector& input, const std::byte* blocks, int num_blocks,
                                         float* results)
{
    const __m512i upper = _mm512_set1_epi32(static_cast<int>(0xFFFF0000U));
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m512 even = _mm512_setzero_ps(), odd = even;
        for (int k = 0; k < input.size(); k += 2, blocks += group_bytes) {
            prefetch(blocks);
            const __m512i pairs = wide_integers_at(blocks);
            even = _mm512_fmadd_ps(_mm512_castsi512_ps(_mm512_slli_epi32(pairs, 16)), _mm512_set1_ps(input.values()[k]),
                                   even);
            odd = _mm512_fmadd_ps(_mm512_castsi512_ps(_mm512_and_si512(pairs, upper)),
                                  _mm512_set1_ps(input.values()[k + 1]), odd);
        }
        _mm512_storeu_ps(results, _mm512_add_ps(_mm512_add_ps(even, odd), wide_floats_at(blocks)));
        blocks += group_bytes;
    }
}

NDG_AVX512_BF16 inline __m512bh halves(__m512i pairs)
{
    return reinterpret_cast<__m512bh>(pairs);
}

/// The input as a sum of two bfloat16, which leaves 16 bits of its mantissa.
NDG_AVX512_BF16 void multiply_bfloat16_dot(const PackedVector& input, const std::byte* blocks, int num_blocks,
                                           float* results)
{
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m512 high = _mm512_setzero_ps(), low = high;
        for (int group = 0; 2 * group < input.size(); ++group, blocks += group_bytes) {
            prefetch(blocks);
            const __m512bh weights = halves(wide_integers_at(blocks));
            const auto first = static_cast<int>(input.high_pairs()[group]);
            const auto second = static_cast<int>(input.low_pairs()[group]);
            high = _mm512_dpbf16_ps(high, weights, halves(_mm512_set1_epi32(first)));
            low = _mm512_dpbf16_ps(low, weights, halves(_mm512_set1_epi32(second)));
        }
        _mm512_storeu_ps(results, _mm512_add_ps(_mm512_add_ps(high, low), wide_floats_at(blocks)));
        blocks += group_bytes;
    }
}

NDG_AVX2 void multiply_int8_avx2(const PackedVector& input, const std::byte* blocks, int num_blocks, float* results)
{
    const __m256 step = _mm256_set1_ps(input.step());
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m256i sums[4];  // of four rows each, of even and of odd pairs of columns
        for (__m256i& sum : sums) sum = _mm256_setzero_si256();
        for (int k = 0; k < input.size(); k += 4, blocks += group_bytes) {
            prefetch(blocks);
            long long four = 0;
            std::memcpy(&four, input.levels() + k, sizeof(four));
            const __m256i levels = _mm256_set1_epi64x(four);
            for (int quarter = 0; quarter < 4; ++quarter) {
                const __m128i weights = _mm_loadu_si128(reinterpret_cast<const __m128i*>(blocks + 16 * quarter));
                sums[quarter] =
                    _mm256_add_epi32(sums[quarter], _mm256_madd_epi16(_mm256_cvtepi8_epi16(weights), levels));
            }
        }
        for (int half = 0; half < 2; ++half) {
            // hadd gives rows 0 1 4 5 and 2 3 6 7 of eight.
            const __m256i mixed = _mm256_hadd_epi32(sums[2 * half], sums[2 * half + 1]);
            const __m256i sum = _mm256_permute4x64_epi64(mixed, 0b11011000);
            const __m256 scales = _mm256_mul_ps(floats_at(blocks + group_bytes + 32 * half), step);
            _mm256_storeu_ps(results + 8 * half, _mm256_add_ps(floats_at(blocks + 32 * half),
                                                               _mm256_mul_ps(scales, _mm256_cvtepi32_ps(sum))));
        }
        blocks += 3 * group_bytes;
    }
}

/// Unsigned bytes of the input times signed ones of the weights: its upper bytes and its lower ones, each sum exact;
/// what the offset of the input adds is known from the weights' sums. All modulo 2^32, in which the result lies.
NDG_AVX512_VNNI void multiply_int8_vnni(const PackedVector& input, const std::byte* blocks, int num_blocks,
                                        float* results)
{
    const __m512 step = _mm512_set1_ps(input.step());
    const int num_groups = (input.size() + 3) / 4;
    for (int b = 0; b < num_blocks; ++b, results += weight_rows) {
        __m512i high[2] = {_mm512_setzero_si512(), _mm512_setzero_si512()};
        __m512i low[2] = {_mm512_setzero_si512(), _mm512_setzero_si512()};
        for (int group = 0; group < num_groups; ++group, blocks += group_bytes) {
            prefetch(blocks);
            const __m512i weights = wide_integers_at(blocks);
            const auto upper = static_cast<int>(input.high_bytes()[group]);
            const auto lower = static_cast<int>(input.low_bytes()[group]);
            high[group % 2] = _mm512_dpbusd_epi32(high[group % 2], _mm512_set1_epi32(upper), weights);
            low[group % 2] = _mm512_dpbusd_epi32(low[group % 2], _mm512_set1_epi32(lower), weights);
        }
        const __m512i offset = _mm512_slli_epi32(wide_integers_at(blocks + 2 * group_bytes), 15);
        const __m512i upper = _mm512_slli_epi32(_mm512_add_epi32(high[0], high[1]), 8);
        const __m512i sum = _mm512_sub_epi32(_mm512_add_epi32(upper, _mm512_add_epi32(low[0], low[1])), offset);
        const __m512 scales = _mm512_mul_ps(wide_floats_at(blocks + group_bytes), step);
        _mm512_storeu_ps(results,
                         _mm512_add_ps(wide_floats_at(blocks), _mm512_mul_ps(scales, _mm512_cvtepi32_ps(sum))));
        blocks += 3 * group_bytes;
    }
}

#endif

std::vector<WeightKernel> all_kernels()
{
    std::vector<WeightKernel> kernels = {{"portable", WeightStorage::float32, true, multiply_float32},
                                         {"portable", WeightStorage::bfloat16, true, multiply_bfloat16},
                                         {"portable", WeightStorage::int8, true, multiply_int8}};
#ifdef __x86_64__
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const bool avx512 = __builtin_cpu_supports("avx512f");
    kernels.push_back({"AVX2", WeightStorage::float32, avx2, multiply_float32_avx2});
    kernels.push_back({"AVX-512", WeightStorage::float32, avx512, multiply_float32_avx512});
    kernels.push_back({"AVX2", WeightStorage::bfloat16, avx2, multiply_bfloat16_avx2});
    kernels.push_back({"AVX-512 BF16", WeightStorage::bfloat16, avx512 && __builtin_cpu_supports("avx512bf16"),
                       multiply_bfloat16_dot});
    kernels.push_back({"AVX-512", WeightStorage::bfloat16, avx512, multiply_bfloat16_avx512});
    kernels.push_back({"AVX2", WeightStorage::int8, avx2, multiply_int8_avx2});
    kernels.push_back({"AVX-512 VNNI", WeightStorage::int8,
                       avx512 && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vnni"),
                       multiply_int8_vnni});
#endif
    return kernels;
}

}  // namespace

const std::vector<WeightKernel>& weight_kernels()
{
    static const std::vector<WeightKernel> kernels = all_kernels();
    return kernels;
}

}  // namespace ndg
