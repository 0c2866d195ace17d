// SPDX-License-Identifier: Apache-2.0
// Every way to multiply against sums in double, with a bound that follows from how weights and inputs are rounded.
#include "ndg/runtime/weight_matrix.h"

#include "ndg/core/random.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <string>

using namespace ndg;

namespace {

struct Product {
    int num_rows = 0, num_columns = 0;
    std::vector<float> weights, biases, input;  ///< rows padded to whole blocks

    Product(int rows, int columns)
        : num_rows(num_weight_blocks(rows) * weight_rows),
          num_columns(columns),
          weights(std::size_t(num_rows) * columns),
          biases(num_rows),
          input(columns)
    {
    }
    std::vector<std::byte> pack(WeightStorage storage) const
    {
        const std::size_t block_bytes = weight_block_bytes(storage, num_columns);
        std::vector<std::byte> blocks(block_bytes * std::size_t(num_rows / weight_rows));
        for (int b = 0; b < num_rows / weight_rows; ++b)
            pack_weight_block(storage, num_columns, weights.data() + std::size_t(b) * weight_rows * num_columns,
                              biases.data() + b * weight_rows, blocks.data() + std::size_t(b) * block_bytes);
        return blocks;
    }
    std::vector<float> multiply(const WeightKernel& kernel) const
    {
        PackedVector packed;
        packed.set(input.data(), num_columns, kernel.storage);
        const std::vector<std::byte> blocks = pack(kernel.storage);
        std::vector<float> results(num_rows);
        kernel.multiply(packed, blocks.data(), num_rows / weight_rows, results.data());
        return results;
    }
    double exact(int row) const
    {
        double sum = double(biases[row]);
        for (int k = 0; k < num_columns; ++k)
            sum += double(weights[std::size_t(row) * num_columns + k]) * double(input[k]);
        return sum;
    }
    /// How far a result may be from exact(row).
    double bound(WeightStorage storage, int row) const
    {
        double of_products = 0, of_inputs = 0, of_weights = 0, largest_weight = 0, largest_input = 0;
        for (int k = 0; k < num_columns; ++k) {
            const double w = std::abs(double(weights[std::size_t(row) * num_columns + k])),
                         x = std::abs(double(input[k]));
            of_products += w * x;
            of_inputs += x;
            of_weights += w;
            largest_weight = std::max(largest_weight, w);
            largest_input = std::max(largest_input, x);
        }
        const double rounding = std::numeric_limits<float>::epsilon() *
                                ((num_columns + 2) * of_products + std::abs(double(biases[row])) + 1e-30);
        if (storage == WeightStorage::float32) return rounding;
        // A bfloat16 has seven bits after the point, so half a unit is 2^-8; two of them keep the input to 2^-16.
        if (storage == WeightStorage::bfloat16)
            return rounding + (std::ldexp(1.0, -8) + std::ldexp(1.0, -16)) * of_products;
        const double most = std::min(32767.0, std::floor(2147483647.0 / (127.0 * num_columns)));
        const double half_weight = 0.5 * largest_weight / 127, half_input = 0.5 * largest_input / most;
        return rounding +
               1.001 * (half_weight * of_inputs + half_input * of_weights + num_columns * half_weight * half_input);
    }
};

/// Inputs as GELU leaves them, mostly small; rows of very different sizes.
Product random_product(int rows, int columns, std::uint64_t seed)
{
    Product product(rows, columns);
    Random random(seed, "weights");
    for (int r = 0; r < product.num_rows; ++r) {
        const double scale = std::pow(10.0, random.uniform(-3, 1));
        for (int k = 0; k < columns; ++k)
            product.weights[std::size_t(r) * columns + k] = float(scale * random.normal());
        product.biases[r] = float(random.normal());
    }
    for (float& x : product.input) x = float(std::max(random.normal(), 0.1 * random.normal()));
    return product;
}

}  // namespace

TEST_CASE("Every kernel multiplies within the bound of its storage")
{
    for (const auto& [rows, columns] :
         {std::pair(16, 1), std::pair(5, 3), std::pair(48, 64), std::pair(33, 601), std::pair(64, 4096)}) {
        const Product product = random_product(rows, columns, std::uint64_t(rows));
        for (const WeightKernel& kernel : weight_kernels()) {
            if (!kernel.is_available) continue;
            const std::vector<float> results = product.multiply(kernel);
            for (int r = 0; r < product.num_rows; ++r) {
                INFO(kernel.name << " with " << to_name(kernel.storage) << ", " << rows << " x " << columns << ", row "
                                 << r);
                CHECK(std::abs(double(results[r]) - product.exact(r)) <= product.bound(kernel.storage, r));
            }
        }
    }
}

TEST_CASE("Kernels of 8 bits agree to the last bit")
{
    const Product product = random_product(160, 603, 3);
    const std::vector<float> expected = product.multiply(weight_kernels()[2]);
    REQUIRE(weight_kernels()[2].storage == WeightStorage::int8);
    for (const WeightKernel& kernel : weight_kernels())
        if (kernel.storage == WeightStorage::int8 && kernel.is_available) {
            INFO(kernel.name);
            CHECK(product.multiply(kernel) == expected);
        }
}

TEST_CASE("Sums of the largest weights and inputs do not overflow")
{
    for (const float sign : {1.0F, -1.0F}) {
        Product product(16, 5000);
        for (float& w : product.weights) w = sign * 3.0F;
        for (float& x : product.input) x = 2.0F;
        for (const WeightKernel& kernel : weight_kernels()) {
            if (!kernel.is_available) continue;
            INFO(kernel.name << " with " << to_name(kernel.storage));
            for (const float result : product.multiply(kernel))
                CHECK(result == Approx(double(sign) * 30000.0).epsilon(1e-3));
        }
    }
}

TEST_CASE("Rows and inputs of zeros give the biases")
{
    Product product = random_product(16, 40, 4);
    for (int k = 0; k < 40; ++k) product.weights[3 * 40 + k] = 0;
    for (const WeightKernel& kernel : weight_kernels())
        if (kernel.is_available) CHECK(product.multiply(kernel)[3] == product.biases[3]);
    std::fill(product.input.begin(), product.input.end(), 0.0F);
    for (const WeightKernel& kernel : weight_kernels())
        if (kernel.is_available) CHECK(product.multiply(kernel) == product.biases);
}

TEST_CASE("The fastest kernel is one that this processor has")
{
    for (const WeightStorage storage : {WeightStorage::float32, WeightStorage::bfloat16, WeightStorage::int8}) {
        CHECK(find_weight_kernel(storage).storage == storage);
        CHECK(find_weight_kernel(storage).is_available);
    }
#ifdef __AVX2__
    CHECK(std::string(find_weight_kernel(WeightStorage::int8).name) != "portable");
#endif
}
