// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/sample_tasks.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using Catch::Contains;

namespace {

const Splits splits = {{}, {}, {{"train", {{0, 0}, {0, 1}, {0, 2}}}, {"test", {{1, 3}}}}};

}  // namespace

TEST_CASE("Shards are parsed and take every n-th pair")
{
    const Shard shard = parse_shard("2/3");
    CHECK(shard.index == 2);
    CHECK(shard.count == 3);
    for (const char* wrong : {"", "3/3", "-1/3", "1", "1/0", "1/3x", "a/b"}) {
        CHECK_THROWS_AS(parse_shard(wrong), InputError);
    }
    const auto tasks = sample_tasks(splits, Shard{0, 3});
    REQUIRE(tasks.size() == 2);
    CHECK(tasks[1].sample_idx == 3);
    CHECK(tasks[1].split == "test");
    CHECK(tasks[1].pair == SamplePair{1, 3});
    CHECK_THROWS_AS(sample_tasks(splits, Shard{5, 9}), InputError);
}

TEST_CASE("A file holds its own shard of its own key, failures among it")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("fem.h5");
    const auto tasks = sample_tasks(splits, Shard{0, 2});
    CHECK_FALSE(holds_samples(path, "key", tasks));
    DeformationSet set;
    set.attributes[sample_key_attribute] = "key";
    set.add({0, 0}, "train", Points::Zero(4, 3));
    set.failures = {{{0, 2}, "train", "no solver can stand this"}};
    write_deformations(path, set, {});
    CHECK(holds_samples(path, "key", tasks));
    CHECK_THROWS_WITH(holds_samples(path, "another", tasks), Contains("other options"));
    CHECK_THROWS_WITH(holds_samples(path, "key", sample_tasks(splits, Shard{1, 2})), Contains("another shard"));
    CHECK_THROWS_WITH(holds_samples(path, "key", sample_tasks(splits, Shard{})), Contains("2 samples of another"));
}
