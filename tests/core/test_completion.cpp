// SPDX-License-Identifier: Apache-2.0
#include "capture.h"
#include "ndg/core/enum_names.h"
#include "ndg/core/file.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <array>
#include <cstdio>

using namespace ndg;
using ndg::test::run_tool;
using ndg::test::TemporaryFolder;
using ndg::test::ToolRun;

namespace {

/// The script of a tool with one flag of each kind, for the name it is called by: "program" (capture.cpp).
std::string script()
{
    double step = 1;
    bool smooth = true;
    std::string method = "exact", body, out;
    Tool tool("make-template", "Makes a template.", "make-template");
    tool.parameter("step", step, "a number", 0.0, 2.0);
    tool.parameter("smooth", smooth, "a bool");
    tool.parameter("method", method, "a choice", {"exact", "fast", "fastest"});
    tool.input("body", body, "a file");  // missing, which does not matter here
    tool.output("out", out, "another");
    tool.listing("list-methods", "exact", "a listing");
    const ToolRun run = run_tool(tool, {"--completion", "bash"}, [] { FAIL("the tool ran"); });
    CHECK(run.exit_code == 0);
    CHECK(run.err.empty());
    return run.out;
}

/// What bash offers where the words of a command line end in `words`, one a line.
std::string completed(const TemporaryFolder& folder, const std::string& words)
{
    const std::string command = "cd " + folder.file("") +
                                " && bash -c 'source ./script && complete -p program > /dev/null && "
                                "COMP_WORDS=(program " +
                                words +
                                ") && COMP_CWORD=$((${#COMP_WORDS[@]} - 1)) && _program && "
                                "printf \"%s\\n\" \"${COMPREPLY[@]}\"' 2>&1";
    std::FILE* const pipe = ::popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::array<char, 4096> buffer = {};
    const std::size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe);
    CHECK(::pclose(pipe) == 0);
    return {buffer.data(), size};
}

}  // namespace

TEST_CASE("Bash completes flags, choices and files of a tool")
{
    const TemporaryFolder folder;
    write_file(folder.file("script"), script());
    write_file(folder.file("two words.h5"), "");
    CHECK(completed(folder, "--s") == "--seed\n--step\n--smooth\n");
    CHECK(completed(folder, "--no") == "--no-smooth\n");
    CHECK(completed(folder, "--li") == "--list-methods\n");
    CHECK(completed(folder, "--method fast") == "fast\nfastest\n");
    CHECK(completed(folder, "--method = fastes") == "fastest\n");
    CHECK(completed(folder, "--method =") == "exact\nfast\nfastest\n");
    CHECK(completed(folder, "--log-level w") == "warning\n");
    CHECK(completed(folder, "--completion \"\"") == "bash\n");
    CHECK(completed(folder, "--body two") == "two words.h5\n");
    CHECK(completed(folder, "--out = two") == "two words.h5\n");
    CHECK(completed(folder, "two") == "two words.h5\n");
    CHECK(completed(folder, "--smooth two") == "two words.h5\n");  // a bool has no value: a file follows
    CHECK(completed(folder, "--step two") == "\n");                // a number is no file
}

TEST_CASE("Completion for another shell is refused")
{
    Tool tool("make-template", "Makes a template.", "make-template");
    const ToolRun run = run_tool(tool, {"--completion", "fish"}, [] {});
    CHECK(run.exit_code == 2);
    CHECK_THAT(run.err, Catch::Contains("--completion: there is one for bash, not for 'fish'"));
}
