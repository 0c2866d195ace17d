// SPDX-License-Identifier: Apache-2.0
// The executable ndg-info as a user runs it.
#include "ndg/core/file.h"
#include "ndg/io/h5.h"
#include "ndg/io/mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

using namespace ndg;
using namespace ndg::test;

namespace {

CommandResult info(const std::string& arguments)
{
    return run_command(tool_path("ndg-info") + " " + arguments);
}

void write_example(const std::string& path)
{
    Provenance provenance;
    provenance.tool = "make-template";
    provenance.licences = "CC0: base mesh\nCC-BY: anatomy";
    H5Writer writer(path, "test-file", 1, provenance);
    writer.write("/skin/vertices", RowMatrix::Random(5000, 3), "positions, m");
    writer.commit();
}

}  // namespace

TEST_CASE("ndg-info shows attributes, datasets and licences")
{
    REQUIRE(std::filesystem::exists(tool_path("ndg-info")));
    const TemporaryFolder folder;
    write_example(folder.file("x.h5"));
    const CommandResult result = info(folder.file("x.h5") + " --check");
    INFO(result.output);
    CHECK(result.exit_code == 0);
    for (const char* part : {"test-file", "CC-BY: anatomy", "/skin/vertices", "float32", "5000 x 3", "positions, m",
                             "\"tool\":\"make-template\"", "complete and finite"}) {
        CHECK_THAT(result.output, Catch::Contains(part));
    }
}

TEST_CASE("ndg-info on broken files: exit code 2 and one line")
{
    REQUIRE(std::filesystem::exists(tool_path("ndg-info")));
    const TemporaryFolder folder;
    write_example(folder.file("x.h5"));
    std::string bytes = read_file(folder.file("x.h5"));
    write_file(folder.file("cut.h5"), bytes.substr(0, bytes.size() / 2));
    bytes[bytes.size() / 2] ^= 1;
    write_file(folder.file("flipped.h5"), bytes);
    const auto check_refused = [&](const std::string& arguments, const std::string& message) {
        const CommandResult result = info(arguments);
        INFO(result.output);
        CHECK(result.exit_code == 2);
        CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
        CHECK_THAT(result.output, Catch::StartsWith("ndg-info: error: ") && Catch::Contains(message));
    };
    check_refused(folder.file("cut.h5"), "cut.h5: cannot open, truncated or damaged");
    check_refused(folder.file("flipped.h5") + " --check", "flipped.h5: cannot read dataset /skin/vertices");
    check_refused(folder.file("missing.h5"), "missing.h5 does not exist");
    check_refused("", "FILE is missing");
}

TEST_CASE("ndg-info on a mesh shows counts and box")
{
    REQUIRE(std::filesystem::exists(tool_path("ndg-info")));
    const TemporaryFolder folder;
    const Points vertices = (Points(3, 3) << 0, 0, 0, 1.5, 0, 0, 0, 2, -1).finished();
    write_mesh(folder.file("x.ply"), vertices, (Triangles(1, 3) << 0, 1, 2).finished());
    const CommandResult result = info(folder.file("x.ply"));
    CHECK(result.exit_code == 0);
    CHECK_THAT(result.output, Catch::Contains("vertices   3") && Catch::Contains("triangles  1") &&
                                  Catch::Contains("0 0 -1 to 1.5 2 0"));
}
