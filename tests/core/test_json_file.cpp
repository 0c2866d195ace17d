// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/json_file.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;

namespace {

JsonValue parsed(const std::string& content)
{
    const test::TemporaryFolder folder;
    write_file(folder.file("a.json"), content);
    return JsonValue(folder.file("a.json"));
}

template <typename Read>
void check_refused(const Read& read, const std::string& message)
{
    INFO(message);
    CHECK_THROWS_AS(read(), InputError);
    CHECK_THROWS_WITH(read(), Contains("a.json: ") && EndsWith(message));
}

}  // namespace

TEST_CASE("values of a JSON file are read, in the order of their keys")
{
    const JsonValue root = parsed(R"({"b": {"x": [1, 2.5], "on": true}, "a": "text", "n": 3})");
    root.check_keys({"a", "b", "n"});
    CHECK(root.at("a").text() == "text");
    CHECK(root.at("a").choice({"tex", "text"}) == 1);
    CHECK(root.at("n").integer(0) == 3);
    CHECK(root.at("b").at("x").numbers(2) == std::vector<double>{1.0, 2.5});
    CHECK(root.at("b").flag_or("on", false));
    CHECK_FALSE(root.at("b").flag_or("off", false));
    CHECK(root.number_or("m", 0.5, 0.0, 1.0) == 0.5);
    CHECK(root.text_or("c", "none") == "none");
    std::string keys;
    for (const auto& [key, value] : root.members()) keys += key;
    CHECK(keys == "abn");
    // A value outlives the object it came from.
    CHECK(parsed(R"({"deep": {"er": 4}})").at("deep").at("er").number() == 4.0);
}

TEST_CASE("errors of a JSON file name file, place, value and what is expected")
{
    check_refused([] { parsed("{\n\"a\": 1,,\n}"); }, "line 2: not valid JSON");
    check_refused([] { parsed("{\"a\": {\"b\": 1, \"b\": 2}}"); }, "key \"b\" stands twice in the same object");
    CHECK_THROWS_WITH(parsed("[1e999]"), Contains("not valid JSON"));
    CHECK_THROWS_WITH(JsonValue("/nowhere.json"), Contains("/nowhere.json"));
    const JsonValue root = parsed(R"({"colour": {"red": [1, {"no": 2}]}, "n": -1, "big": 3000000000, "half": 0.5})");
    check_refused(
        [&] {
            root.at("colour").check_keys({"read", "green"});
        },
        "colour: unknown key \"red\", did you mean \"read\"?");
    check_refused([&] { root.at("colour").at("blue"); }, "colour: has no \"blue\"");
    check_refused([&] { root.at("colour").at("red").elements(3); },
                  "colour.red: expected a list of 3, got [1,{\"no\":2}]");
    check_refused([&] { root.at("colour").at("red").numbers(); }, "colour.red[1]: expected a number, got {\"no\":2}");
    check_refused([&] { root.at("n").number(0.0, 1.0); }, "n: expected a number in [0, 1], got -1");
    check_refused([&] { root.at("n").has("x"); }, "n: expected an object, got -1");
    check_refused([&] { root.at("n").integer(0); }, "n: expected an integer >= 0, got -1");
    check_refused([&] { root.at("big").integer(0); }, "big: expected an integer >= 0, got 3000000000");
    check_refused([&] { root.at("half").integer(0, 3); }, "half: expected an integer in [0, 3], got 0.5");
    check_refused([&] { root.at("half").flag(); }, "half: expected true or false, got 0.5");
    check_refused([&] { root.at("half").choice({"low", "high"}); }, "half: expected one of low | high, got 0.5");
}
