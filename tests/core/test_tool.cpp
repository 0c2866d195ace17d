// SPDX-License-Identifier: Apache-2.0
#include "capture.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/hash.h"
#include "support/support.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <new>

using namespace ndg;
using ndg::test::run_tool;
using ndg::test::TemporaryFolder;
using ndg::test::ToolRun;

namespace {

/// A tool with one parameter of each type.
struct Example {
    double target_edge_length = 0.03;
    int num_bodies = 5;
    bool smooth = true;
    std::vector<int> layer_widths = {8, 4};
    std::string method = "exact";
    std::string body, out;
    std::vector<std::string> scans;
    Tool tool{"make-template", "Makes a template.", "make-template --out template.h5"};

    Example()
    {
        tool.parameter("target-edge-length", target_edge_length, "edge length, m", 0.001, 0.1);
        tool.parameter("num-bodies", num_bodies, "how many", 1, std::numeric_limits<int>::max());
        tool.parameter("smooth", smooth, "smooth the skin");
        tool.parameter("layer-widths", layer_widths, "widths of the layers");
        tool.parameter("method", method, "how", {"exact", "fast"});
        tool.input("body", body, "body file", false);
        tool.input("scans", scans, "scans", false);
        tool.output("out", out, "result", false);
    }
    ToolRun run(
        const std::vector<std::string>& arguments, const std::function<void()>& body_function = [] {})
    {
        return run_tool(tool, arguments, body_function);
    }
};

void check_refused(const ToolRun& result, const std::string& message)
{
    CHECK(result.exit_code == 2);
    CHECK(result.out.empty());
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK_THAT(result.err, Catch::StartsWith("make-template: error: "));
    CHECK_THAT(result.err, Catch::Contains(message));
}

void check_config_refused(const std::string& content, const std::string& message)
{
    const TemporaryFolder folder;
    write_file(folder.file("c.json"), content);
    Example example;
    bool ran = false;
    const ToolRun result = example.run({"--config", folder.file("c.json")}, [&] { ran = true; });
    check_refused(result, message);
    CHECK_THAT(result.err, Catch::Contains(folder.file("c.json")));
    CHECK_FALSE(ran);
}

}  // namespace

TEST_CASE("command line beats config file, config file beats default")
{
    const TemporaryFolder folder;
    write_file(folder.file("c.json"),
               R"({"description": "both", "seed": 7, "train-ndg": {"epochs": 3}, "propose-joint-map": {},
        "make-template": {"target_edge_length": 0.02, "num_bodies": 9, "layer_widths": [1, 2, 3], "smooth": false}})");
    Example example;
    const ToolRun result = example.run({"--config", folder.file("c.json"), "--num-bodies", "11"});
    REQUIRE(result.exit_code == 0);
    CHECK(example.num_bodies == 11);
    CHECK(example.target_edge_length == 0.02);
    CHECK(example.layer_widths == std::vector<int>{1, 2, 3});
    CHECK_FALSE(example.smooth);
    CHECK(example.method == "exact");
    CHECK(example.tool.seed() == 7);

    const auto config = nlohmann::json::parse(example.tool.provenance().config_json);
    CHECK(config == nlohmann::json::parse(R"({"make-template": {"target_edge_length": 0.02, "num_bodies": 11,
        "layer_widths": [1, 2, 3], "smooth": false, "method": "exact", "seed": 7}})"));
}

TEST_CASE("seed: command line, then section, then top level")
{
    const TemporaryFolder folder;
    write_file(folder.file("c.json"), R"({"seed": 7, "make-template": {"seed": 8}})");
    Example from_section, from_line, untouched;
    CHECK(from_section.run({"--config", folder.file("c.json")}).exit_code == 0);
    CHECK(from_section.tool.seed() == 8);
    CHECK(from_line.run({"--config", folder.file("c.json"), "--seed", "18446744073709551615"}).exit_code == 0);
    CHECK(from_line.tool.seed() == 18446744073709551615ULL);
    CHECK(untouched.run({}).exit_code == 0);
    CHECK(untouched.tool.seed() == 1);
}

TEST_CASE("values of every type on the command line")
{
    Example example;
    REQUIRE(example.run({"--no-smooth", "--layer-widths", "3,4,5", "--method=fast", "--target-edge-length", "1e-2"})
                .exit_code == 0);
    CHECK_FALSE(example.smooth);
    CHECK(example.layer_widths == std::vector<int>{3, 4, 5});
    CHECK(example.method == "fast");
    CHECK(example.target_edge_length == 0.01);
    Example spaced;
    REQUIRE(spaced.run({"--layer-widths", "3", "4", "--smooth"}).exit_code == 0);
    CHECK(spaced.layer_widths == std::vector<int>{3, 4});
    CHECK(spaced.smooth);
}

TEST_CASE("the printed config can be read back")
{
    const TemporaryFolder folder;
    Example first;
    const ToolRun printed = first.run({"--print-config", "--num-bodies", "3", "--target-edge-length", "0.0123"});
    REQUIRE(printed.exit_code == 0);
    write_file(folder.file("c.json"), printed.out);
    Example second;
    const ToolRun again = second.run({"--print-config", "--config", folder.file("c.json")});
    CHECK(again.out == printed.out);
    CHECK(second.num_bodies == 3);
    CHECK(second.target_edge_length == 0.0123);
}

TEST_CASE("unknown keys and sections name the nearest known one")
{
    check_config_refused(R"({"make-template": {"target_edge_lenght": 0.02}})",
                         "unknown key \"target_edge_lenght\" in section \"make-template\", did you mean "
                         "\"target_edge_length\"?");
    check_config_refused(R"({"make-tempalte": {}})",
                         "unknown section \"make-tempalte\", did you mean \"make-template\"?");
    check_config_refused(R"({"sed": 3})", "did you mean \"seed\"?");
}

TEST_CASE("values of the wrong type or out of range name key, value and what is expected")
{
    check_config_refused(R"({"make-template": {"num_bodies": "nine"}})",
                         "make-template.num_bodies: expected an integer >= 1, got \"nine\"");
    check_config_refused(R"({"make-template": {"num_bodies": 2.5}})", "expected an integer >= 1, got 2.5");
    check_config_refused(R"({"make-template": {"num_bodies": 0}})", "expected an integer >= 1, got 0");
    check_config_refused(R"({"make-template": {"num_bodies": 3000000000}})", "got 3000000000");
    check_config_refused(R"({"make-template": {"target_edge_length": 0.2}})",
                         "expected a number in [0.001, 0.1], got 0.2");
    check_config_refused(R"({"make-template": {"smooth": 1}})", "smooth: expected true or false, got 1");
    check_config_refused(R"({"make-template": {"method": "slow"}})", "expected one of exact | fast, got \"slow\"");
    check_config_refused(R"({"make-template": {"layer_widths": [1, "a"]}})",
                         "expected a list of integers, got [1,\"a\"]");
    check_config_refused(R"({"make-template": 3})", "section \"make-template\": expected an object, got 3");
    check_config_refused(R"({"seed": -1})", "seed: expected an integer >= 0, got -1");
    check_config_refused(R"([1])", "expected a JSON object with one section a tool, got array");
}

TEST_CASE("broken JSON names the line; a repeated key is an error")
{
    check_config_refused("{\n\"make-template\": {\n\"num_bodies\": 3,,\n}}", "line 3: not valid JSON");
    check_config_refused("", "line 1: not valid JSON");
    check_config_refused(R"({"make-template": {"num_bodies": 3, "num_bodies": 4}})", "\"num_bodies\" stands twice");
}

TEST_CASE("wrong arguments give exit code 2 and one line")
{
    const auto refused = [](const std::vector<std::string>& arguments, const std::string& message) {
        Example example;
        check_refused(example.run(arguments), message);
    };
    refused({"--num-bodis", "3"}, "unknown option --num-bodis, did you mean --num-bodies?");
    refused({"--num-bodies", "0"}, "--num-bodies: expected an integer >= 1, got '0'");
    refused({"--num-bodies", "3x"}, "got '3x'");
    refused({"--num-bodies"}, "--num-bodies");
    refused({"--target-edge-length", "nan"}, "expected a number in [0.001, 0.1], got 'nan'");
    refused({"--method", "slow"}, "expected one of exact | fast, got 'slow'");
    refused({"--layer-widths", "1,,2"}, "expected a list of integers, got '1,,2'");
    refused({"--seed", "-1"}, "--seed: expected an integer >= 0");
    refused({"--threads", "-1"}, "number of threads must be 0 (all cores) or more, got -1");
    refused({"--log-level", "loud"}, "--log-level: \"loud\" is none of debug | info | warning | error | off");
    refused({"stray"}, "unexpected argument 'stray'");
    refused({"--config", "/nowhere/c.json"}, "/nowhere/c.json: does not exist");
    refused({"--body", "/nowhere/body.h5"}, "--body: /nowhere/body.h5 does not exist");
}

TEST_CASE("required files")
{
    std::string in, out;
    const auto run = [&](const std::vector<std::string>& arguments) {
        Tool tool("make-template", "s", "e");
        tool.input("body", in, "body");
        tool.output("out", out, "result");
        return run_tool(tool, arguments);
    };
    check_refused(run({}), "--body is missing");
    const TemporaryFolder folder;
    write_file(folder.file("in"), "x");
    in.clear();
    check_refused(run({"--body", folder.file("in")}), "--out is missing");
    CHECK(run({"--body", folder.file("in"), "--out", folder.file("a/b/out")}).exit_code == 0);
    CHECK(std::filesystem::is_directory(folder.file("a/b")));
}

TEST_CASE("an existing output is refused without --force, unless it can be resumed")
{
    const TemporaryFolder folder;
    write_file(folder.file("out"), "old");
    Example plain, forced;
    check_refused(plain.run({"--out", folder.file("out")}), "exists already, give --force to overwrite it");
    CHECK(forced.run({"--out", folder.file("out"), "--force"}).exit_code == 0);
    CHECK(forced.tool.force());
    Example itself;
    check_refused(itself.run({"--body", folder.file("out"), "--out", folder.file("out"), "--force"}),
                  "is also the input");
    Example a_folder;
    check_refused(a_folder.run({"--out", folder.path(), "--force"}), "is a folder, expected a file");

    std::string out;
    Tool resumable("make-template", "s", "e");
    resumable.output("out", out, "result", true, true);
    CHECK(run_tool(resumable, {"--out", folder.file("out")}).exit_code == 0);
}

TEST_CASE("inputs and outputs that are no files, and names that are no text, are refused before anything is done")
{
    const TemporaryFolder folder;
    REQUIRE(::mkfifo(folder.file("pipe").c_str(), 0666) == 0);
    write_file(folder.file("J\xF6rg"), "x");
    const auto refused = [&](const std::string& flag, const std::string& path, const std::string& message) {
        Example example;
        bool ran = false;
        check_refused(example.run({flag, path, "--force"}, [&] { ran = true; }), message);
        CHECK_FALSE(ran);
    };
    refused("--body", folder.file("pipe"), "is a pipe or device");
    refused("--body", folder.file("J\xF6rg"), "J?rg is not UTF-8");
    refused("--out", folder.file("pipe"), "is a pipe or device");
    refused("--out", "/dev/null", "is a pipe or device");
    refused("--out", folder.file("J\xF6rg"), "J?rg is not UTF-8");
    refused("--out", "/proc/x", "cannot write to /proc");
    CHECK(std::filesystem::is_fifo(folder.file("pipe")));
    CHECK(std::filesystem::is_character_file("/dev/null"));
    // The trial of an output leaves nothing.
    Example example;
    CHECK(example.run({"--out", folder.file("new")}).exit_code == 0);
    CHECK_FALSE(std::filesystem::exists(folder.file("new")));
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("what a message quotes cannot disturb a terminal")
{
    Example example;
    const ToolRun result = example.run({}, [] { throw InputError("x.bvh: '\x1B[2J\xFF\x07' is no number"); });
    check_refused(result,
                  "x.bvh: '?[2J?"
                  "?' is no number");
}

TEST_CASE("exceptions become exit codes and one line")
{
    const auto exit_code = [](const std::function<void()>& body, const std::string& line) {
        Example example;
        const ToolRun result = example.run({}, body);
        CHECK(result.err == "make-template: error: " + line + "\n");
        return result.exit_code;
    };
    CHECK(exit_code([] { throw Error("failed"); }, "failed") == 1);
    CHECK(exit_code([] { throw SolverError("singular"); }, "singular") == 1);
    CHECK(exit_code([] { throw InputError("bad\nfile"); }, "bad file") == 2);
    CHECK(exit_code([] { throw QualityError("gate"); }, "gate") == 3);
    CHECK(exit_code([] { throw Interrupted("stopped"); }, "stopped") == 75);
    CHECK(exit_code([] { throw std::runtime_error("other"); }, "other") == 1);
    CHECK(exit_code([] { throw std::bad_alloc(); }, "out of memory") == 1);
    CHECK(exit_code([] { throw 3; }, "unknown failure") == 1);
}

TEST_CASE("help fits a screen and shows example, defaults and ranges")
{
    Example example;
    bool ran = false;
    const ToolRun result = example.run({"--help"}, [&] { ran = true; });
    CHECK(result.exit_code == 0);
    CHECK_FALSE(ran);
    CHECK(std::count(result.out.begin(), result.out.end(), '\n') <= 24);
    for (const char* part : {"make-template --out template.h5", "--target-edge-length NUM", "[0.001, 0.1]",
                             "(default 0.03)", "exact | fast", "(default 8,4)", "--[no-]smooth", "--scans FILE..."}) {
        CHECK_THAT(result.out, Catch::Contains(part));
    }
    Example versioned;
    CHECK_THAT(versioned.run({"--version"}).out, Catch::StartsWith("make-template " + project_version() + " ("));
}

TEST_CASE("provenance names every input and the config with their hashes")
{
    const TemporaryFolder folder;
    write_file(folder.file("a"), "abc");
    write_file(folder.file("b"), "");
    write_file(folder.file("c.json"), "{}");
    Example example;
    Provenance provenance;
    REQUIRE(example
                .run({"--scans", folder.file("a"), folder.file("b"), "--config", folder.file("c.json")},
                     [&] { provenance = example.tool.provenance("CC0: someone"); })
                .exit_code == 0);
    CHECK(provenance.tool == "make-template");
    CHECK(provenance.licences == "CC0: someone");
    REQUIRE(provenance.inputs.size() == 3);
    CHECK(provenance.inputs[0].path == folder.file("a"));
    CHECK(provenance.inputs[0].sha256 == sha256("abc"));
    CHECK(provenance.inputs[1].sha256 == sha256(""));
    CHECK(provenance.inputs[2].sha256 == sha256("{}"));
}

TEST_CASE("a positional input")
{
    const TemporaryFolder folder;
    write_file(folder.file("a"), "abc");
    std::string path;
    Tool tool("make-template", "s", "e");
    tool.positional_input(path, "file to show");
    check_refused(run_tool(tool, {}), "FILE is missing");
    CHECK(run_tool(tool, {folder.file("a")}).exit_code == 0);
    CHECK(path == folder.file("a"));
}
