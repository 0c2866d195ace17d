// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/expectations.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;

namespace {

struct Run {
    test::TemporaryFolder folder;
    std::string tables = folder.file("tables.json"), expectations = folder.file("expectations.json");

    /// Figures of NDG and LBS, what is expected: how many expectations are broken.
    int broken(double ndg, double lbs, const std::string& expected, double converged = 1.0)
    {
        write_file(tables, fmt::format(R"({{"table1": {{"NDG": {{"E_pos_mm": {}}}, "LBS": {{"E_pos_mm": {}}}}},
            "counts": {{"fem_converged_share": {}}}}})",
                                       ndg, lbs, converged));
        write_file(expectations, expected);
        const auto checks = check_expectations(tables, expectations);
        return int(std::count_if(checks.begin(), checks.end(), [](const auto& check) { return !check.holds; }));
    }
};

const char* const order = R"({"table1": {"order": {"E_pos_mm": ["NDG", "LBS"]}}})";
const char* const ratio =
    R"({"table1": {"ratios": [{"methods": ["NDG", "LBS"], "tolerance": 0.25, "E_pos_mm": 0.4}]}})";

}  // namespace

TEST_CASE_METHOD(Run, "An order of methods must hold strictly")
{
    CHECK(broken(1.0, 2.0, order) == 0);
    CHECK(broken(2.0, 1.0, order) == 1);
    CHECK(broken(2.0, 2.0, order) == 1);
}

TEST_CASE_METHOD(Run, "A ratio must lie within its tolerance on both sides")
{
    CHECK(broken(4.0, 10.0, ratio) == 0);
    CHECK(broken(4.9, 10.0, ratio) == 0);
    CHECK(broken(3.3, 10.0, ratio) == 0);
    CHECK(broken(5.1, 10.0, ratio) == 1);
    CHECK(broken(3.1, 10.0, ratio) == 1);
    CHECK(broken(10.0, 10.0, ratio) == 1);  // what a network gives that has learnt nothing
    CHECK(broken(0.0, 0.0, ratio) == 1);
}

TEST_CASE_METHOD(Run, "Ranges of measures and counts")
{
    const char* const ranges =
        R"({"description": "x", "table1": {"ranges": {"NDG": {"E_pos_mm": [0, 1]}}}, "counts": {"fem_converged_share": [0.99, 1]}})";
    CHECK(broken(1.0, 2.0, ranges) == 0);
    CHECK(broken(1.1, 2.0, ranges) == 1);
    CHECK(broken(1.0, 2.0, ranges, 0.9) == 1);
}

TEST_CASE_METHOD(Run, "What the tables lack, and what says nothing, is refused by name")
{
    CHECK_THROWS_WITH(broken(1, 2, R"({"table1": {"order": {"E_pos_mm": ["NDG", "VertexNet"]}}})"),
                      Catch::Contains("tables.json") && Catch::Contains("VertexNet"));
    CHECK_THROWS_WITH(broken(1, 2, R"({"table1": {"ordr": {}}})"), Catch::Contains("order"));
    CHECK_THROWS_AS(broken(1, 2, R"({"table1": {"order": {"E_pos_mm": ["NDG"]}}})"), InputError);
    CHECK_THROWS_AS(broken(1, 2, R"({"table2": {"order": {"E_pos_mm": ["NDG", "LBS"]}}})"), InputError);
    CHECK_THROWS_AS(broken(1, 2, R"({"description": "nothing"})"), InputError);
}
