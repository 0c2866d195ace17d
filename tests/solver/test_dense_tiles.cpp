// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/solver/dense_tiles.h"

#include <catch2/catch.hpp>

#include <array>
#include <cstring>
#include <vector>

using namespace ndg;

TEST_CASE("A tile's products are right, and bit for bit the same in every kernel", "[solver][dense_tiles]")
{
    constexpr std::size_t stride = 40;
    Random random(3, "tiles");
    for (const int depth : {1, 2, 5, 18, 96}) {
        std::vector<float> a(stride * depth + tile_rows);
        for (float& value : a) value = static_cast<float>(random.uniform(-1, 1));
        for (const bool narrow : {false, true}) {
            for (const int rows : {3, 8, 9, 16}) {
                TileProduct tile;
                tile.a = a.data() + 7;
                tile.b = a.data() + 2;
                tile.stride = stride;
                tile.depth = depth;
                tile.rows = rows;
                tile.narrow = narrow;
                std::array<float, tile_rows * tile_columns> product{}, wide{};
                multiply_tile(tile, product.data());
                const int columns = narrow ? tile_columns / 2 : tile_columns;
                CAPTURE(depth, narrow, rows);
                for (int c = 0; c < columns; ++c) {
                    for (int r = 0; r < rows; ++r) {
                        double expected = 0;
                        for (int k = 0; k < depth; ++k) {
                            const std::size_t column = stride * k;
                            expected +=
                                static_cast<double>(tile.a[column + r]) * static_cast<double>(tile.b[column + c]);
                        }
                        REQUIRE(std::abs(product[tile_rows * c + r] - expected) < 1e-5);
                    }
                }
                if (wide_tile_kernel() == nullptr) continue;
                wide_tile_kernel()(tile, wide.data());
                for (int c = 0; c < columns; ++c) {
                    const int begin = tile_rows * c;
                    REQUIRE(std::memcmp(&product[begin], &wide[begin], rows * sizeof(float)) == 0);
                }
            }
        }
    }
}
