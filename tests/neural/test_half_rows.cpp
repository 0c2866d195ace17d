// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/half_rows.h"

#include <catch2/catch.hpp>

#include <thread>
#include <vector>

using namespace ndg;

TEST_CASE("rows are kept up to the bound and rounded alike whether kept or not")
{
    const std::vector<float> origin = {1.0f, 0.0f, 0.5f};
    HalfRows rows(origin, 4, 2 * HalfRows::bytes_of(1, 3) + 1);  // room for two
    const std::vector<float> exact = {1.1f, -3.0f, 0.5f};
    std::vector<std::vector<float>> rounded(4, exact);
    CHECK(rows.keep(2, rounded[2].data()));
    CHECK(rows.keep(0, rounded[0].data()));
    CHECK(!rows.keep(1, rounded[1].data()));
    CHECK(!rows.keep(2, rounded[3].data()));  // there already
    for (const std::vector<float>& row : rounded) CHECK(row == rounded[0]);
    CHECK(rounded[0][0] == Approx(1.1).margin(0.1 / 2048));
    CHECK(rounded[0][0] != exact[0]);
    CHECK(rounded[0][1] == -3.0f);
    CHECK(rounded[0][2] == 0.5f);
    std::vector<float> read(3);
    CHECK(rows.read(2, read.data()));
    CHECK(read == rounded[2]);
    CHECK(!rows.read(1, read.data()));
    CHECK(!rows.read(3, read.data()));
}

TEST_CASE("rows are kept once, by whichever thread comes first")
{
    HalfRows rows({0.0f, 0.0f}, 50, 1e6);
    std::vector<int> kept(400);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (int i = t; i < 400; i += 4) {
                std::vector<float> values = {static_cast<float>(i % 50), 1.0f};
                kept[i] = rows.keep(i % 50, values.data());
            }
        });
    for (std::thread& thread : threads) thread.join();
    int count = 0;
    for (const int one : kept) count += one;
    CHECK(count == 50);
    for (int row = 0; row < 50; ++row) {
        std::vector<float> values(2);
        REQUIRE(rows.read(row, values.data()));
        CHECK(values[0] == static_cast<float>(row));
    }
}
