// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/evaluate/expectations.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("check-results",
              "Compares the tables of a run with stored expectations: orders of methods, ratios, ranges. Exits with 3 "
              "where one does not hold.",
              "check-results --tables out/demo/report/tables.json --expectations configs/expectations/demo.json");
    std::string tables_path, expectations_path;
    tool.input("tables", tables_path, "tables.json of the run");
    tool.input("expectations", expectations_path, "what it must show (docs/formats.md)");
    return tool.run(argc, argv, [&] {
        const std::vector<CheckedExpectation> checks = check_expectations(tables_path, expectations_path);
        std::vector<std::string> broken;
        for (const CheckedExpectation& check : checks) {
            fmt::print("{}  {}\n", check.holds ? "ok  " : "FAIL", check.text);
            if (!check.holds) broken.push_back(check.text);
        }
        if (!broken.empty())
            throw QualityError(fmt::format("{} of {} expectations of {} do not hold: {}", broken.size(), checks.size(),
                                           expectations_path, broken.front()));
    });
}
