// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/makehuman/files.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <zlib.h>

using namespace ndg;
using Catch::Matchers::Contains;

TEST_CASE("targets are read, and bad ones named", "[build]")
{
    const test::TemporaryFolder folder;
    const auto write = [&](const std::string& name, const std::string& text) {
        gzFile file = gzopen(folder.file(name).c_str(), "wb");
        REQUIRE(file != nullptr);
        gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
        gzclose(file);
        return folder.file(name);
    };
    const MakeHumanTarget target = read_makehuman_target(write("good.gz", "# comment\n2 .5 -1 0\n0 0 0 3e-1\n"), 3);
    REQUIRE(target.vertices == std::vector<int>{2, 0});
    CHECK(target.offsets(0, 0) == 0.5);
    CHECK(target.offsets(1, 2) == 0.3);
    CHECK_THROWS_WITH(read_makehuman_target(write("range.gz", "3 0 0 0\n"), 3),
                      Contains("range.gz") && Contains("vertex 3"));
    CHECK_THROWS_WITH(read_makehuman_target(write("word.gz", "1 0 x 0\n"), 3), Contains("line 1"));
    CHECK_THROWS_AS(read_makehuman_target(folder.file("missing.gz"), 3), InputError);
}
