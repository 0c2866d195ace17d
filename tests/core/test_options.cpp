// SPDX-License-Identifier: Apache-2.0
#include "capture.h"
#include "ndg/core/error.h"
#include "ndg/core/options.h"
#include "support/described.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

namespace ndg {

enum class Colour { red, dark_blue };
template <>
inline constexpr EnumName<Colour> enum_table<Colour>[] = {{Colour::red, "red"}, {Colour::dark_blue, "dark-blue"}};

struct PaintOptions {
    double thickness = 0.1;
    int coats = 2;
    bool gloss = false;
    std::vector<int> layers = {3, 1};
    Colour colour = Colour::dark_blue;
    double report_seconds = 60;
    int grain = 7;
};
struct ForgetfulOptions {
    bool first = true;
    int second = 2;
    int third = 3;
};

void describe(OptionList& list, PaintOptions& options)
{
    list.add("thickness", options.thickness, "of a coat, mm", 0.05, 0.5);
    list.add("coats", options.coats, "how many", 1, 5);
    list.add("gloss", options.gloss, "shine");
    list.add("layers", options.layers, "of the brush", 1, 9);
    list.add("colour", options.colour, "of the wall");
    list.add("report-seconds", options.report_seconds, "between reports", 0, 1e9).run_only();
    list.add("grain", options.grain, "of the paper", 1, 10).no_flag();
}

void describe(OptionList& list, ForgetfulOptions& options)
{
    list.add("first", options.first, "a bool and its padding");
    list.add("second", options.second, "an int", 0, 9);
}

}  // namespace ndg

using namespace ndg;
using Catch::Contains;
using ndg::test::run_tool;

TEST_CASE("an enum has one table of names")
{
    CHECK(to_name(Colour::dark_blue) == "dark-blue");
    CHECK(parse_name<Colour>("red") == Colour::red);
    CHECK(names<Colour>() == std::vector<std::string>{"red", "dark-blue"});
    CHECK_FALSE(find_name<Colour>("blue"));
    CHECK_THROWS_WITH(parse_name<Colour>("blue", "wall.h5"), "wall.h5: \"blue\" is none of red | dark-blue");
    CHECK_THROWS_AS(to_name(static_cast<Colour>(7)), Error);
}

TEST_CASE("values out of range are refused from code too")
{
    CHECK_NOTHROW(check_options(PaintOptions()));
    const auto refused = [](const auto& change, const std::string& message) {
        PaintOptions options;
        change(options);
        CHECK_THROWS_AS(check_options(options), InputError);
        CHECK_THROWS_WITH(check_options(options), message);
    };
    refused([](auto& o) { o.thickness = 0.6; }, "thickness: expected a number in [0.05, 0.5], got 0.6");
    refused([](auto& o) { o.thickness = std::nan(""); }, "thickness: expected a number in [0.05, 0.5], got nan");
    refused([](auto& o) { o.report_seconds = std::numeric_limits<double>::infinity(); },
            "report-seconds: expected a number in [0, 1000000000], got inf");
    refused([](auto& o) { o.coats = 0; }, "coats: expected an integer in [1, 5], got 0");
    refused([](auto& o) { o.layers.push_back(10); }, "layers: expected a list of integers in [1, 9], got 3,1,10");
    refused([](auto& o) { o.grain = 11; }, "grain: expected an integer in [1, 10], got 11");
}

TEST_CASE("the key of a run changes with every value that affects the result, however little")
{
    const std::string key = options_key(PaintOptions());
    CHECK(key == R"({"coats":2,"colour":"dark-blue","gloss":false,"grain":7,"layers":[3,1],"thickness":0.1})");
    const auto changed = [&](const auto& change) {
        PaintOptions options;
        change(options);
        return options_key(options) != key;
    };
    CHECK(changed([](auto& o) { o.thickness = std::nextafter(0.1, 1.0); }));
    CHECK(changed([](auto& o) { o.coats = 3; }));
    CHECK(changed([](auto& o) { o.gloss = true; }));
    CHECK(changed([](auto& o) { o.layers = {31}; }));
    CHECK(changed([](auto& o) { o.colour = Colour::red; }));
    CHECK(changed([](auto& o) { o.grain = 8; }));
    CHECK_FALSE(changed([](auto& o) { o.report_seconds = 1; }));
}

TEST_CASE("a flag is described once")
{
    OptionList list;
    PaintOptions options;
    describe(list, options);
    CHECK_THROWS_WITH(list.add("coats", options.grain, "again", 0, 1), Contains("coats is described twice"));
}

TEST_CASE("a field that its struct's description forgot is found")
{
    CHECK(test::undescribed_bytes<PaintOptions>().empty());
    CHECK(test::undescribed_bytes<ForgetfulOptions>() == std::vector<std::size_t>{8, 9, 10, 11});
}

TEST_CASE("a tool takes its flags from the description")
{
    PaintOptions options;
    Tool tool("make-template", "s", "e");
    tool.options(options);
    const std::vector<std::string> arguments = {"--thickness", "0.2", "--colour", "red", "--report-seconds", "1"};
    REQUIRE(run_tool(tool, arguments).exit_code == 0);
    CHECK(options.thickness == 0.2);
    CHECK(options.colour == Colour::red);
    CHECK(options.report_seconds == 1);
    CHECK_THAT(tool.provenance().config_json, Contains(R"("colour":"red")") && !Contains("grain"));

    Tool help("make-template", "s", "e");
    help.options(options);
    const test::ToolRun shown = run_tool(help, {"--help"});
    for (const char* line : {"--thickness NUM       of a coat, mm, [0.05, 0.5] (default 0.2)",
                             "--colour TEXT         of the wall, red | dark-blue (default red)",
                             "--layers INT,INT,...  of the brush, [1, 9] (default 3,1)"}) {
        CHECK_THAT(shown.out, Contains(line));
    }
    CHECK_THAT(shown.out, !Contains("grain"));

    Tool wrong("make-template", "s", "e");
    wrong.options(options);
    CHECK_THAT(run_tool(wrong, {"--colour", "blue"}).err, Contains("--colour: expected one of red | dark-blue"));
    Tool hidden("make-template", "s", "e");
    hidden.options(options);
    CHECK_THAT(run_tool(hidden, {"--grain", "8"}).err, Contains("unknown option --grain"));
}
