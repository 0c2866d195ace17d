// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/sample_inputs.h"

#include "ndg/core/error.h"
#include "support/small_dataset.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

enum class Which { files, splits, samples };

struct Fixture {
    test::TemporaryFolder folder;
    test::SmallDataset dataset = test::small_dataset(4, 5);

    Fixture() { test::write_small_dataset(folder.path(), dataset); }

    /// Exit code of a tool that reads the inputs, given these arguments beside the files.
    int read(SampleInputs& inputs, std::vector<std::string> arguments, Which which = Which::samples) const
    {
        Tool tool("test-inputs", "Reads inputs.", "test-inputs");
        inputs.add_files(tool);
        if (which == Which::splits) inputs.add_splits(tool);
        if (which == Which::samples) inputs.add_samples(tool);
        arguments.insert(arguments.begin(), "test-inputs");
        for (const char* name : {"template", "bodies", "poses"}) {
            arguments.push_back(std::string("--") + name + "=" + folder.file(std::string(name) + ".h5"));
        }
        std::vector<char*> words;
        for (std::string& argument : arguments) words.push_back(argument.data());
        return tool.run(int(words.size()), words.data(), [&] { inputs.read(); });
    }
};

}  // namespace

TEST_CASE_METHOD(Fixture, "Samples are the pairs of a split, or a body in all poses or in one")
{
    const std::string splits = "--splits=" + folder.file("splits.h5");
    SampleInputs test, validation, body, pose, none;
    REQUIRE(read(test, {splits}) == exit_done);
    CHECK(test.samples.pairs == dataset.splits.pairs.at("test"));
    CHECK(test.samples.pair_splits == std::vector<std::string>(test.samples.pairs.size(), "test"));
    CHECK(test.bodies.bodies.size() == 4);
    REQUIRE(read(validation, {splits, "--split=validation"}) == exit_done);
    CHECK(validation.samples.pairs == dataset.splits.pairs.at("validation"));
    REQUIRE(read(body, {"--body=2", "--split=train"}) == exit_done);
    REQUIRE(body.samples.size() == dataset.poses.size());
    CHECK(body.samples.pairs[7] == SamplePair{2, 7});
    CHECK(body.samples.pair_splits[7] == "train");
    REQUIRE(read(pose, {"--body=2", "--pose=7"}) == exit_done);
    CHECK(pose.samples.pairs == std::vector<SamplePair>{{2, 7}});
    REQUIRE(read(none, {}, Which::files) == exit_done);
    CHECK(none.samples.pairs.empty());
    CHECK(none.poses.size() == dataset.poses.size());
}

TEST_CASE_METHOD(Fixture, "All splits, or a body in poses without any")
{
    SampleInputs all, body, both;
    REQUIRE(read(all, {"--splits=" + folder.file("splits.h5")}, Which::splits) == exit_done);
    CHECK(all.splits.pairs == dataset.splits.pairs);
    CHECK_FALSE(all.by_body());
    CHECK(all.samples.pairs.empty());
    REQUIRE(read(body, {"--body=2", "--pose=7"}, Which::splits) == exit_done);
    CHECK(body.by_body());
    CHECK(body.splits.pairs.at("test") == std::vector<SamplePair>{{2, 7}});
    CHECK(body.splits.pairs.at("train").empty());
    CHECK(body.splits.poses.at("test") == std::vector<int>{7});
    CHECK(read(both, {}, Which::splits) == exit_bad_input);
}

TEST_CASE_METHOD(Fixture, "Samples that are not there, or asked for in two ways, are input errors")
{
    const std::string splits = "--splits=" + folder.file("splits.h5");
    const std::vector<std::vector<std::string>> wrong = {
        {}, {splits, "--body=0"}, {splits, "--pose=0"}, {"--body=4"}, {"--body=0", "--pose=25"}};
    for (const std::vector<std::string>& arguments : wrong) {
        SampleInputs inputs;
        CHECK(read(inputs, arguments) == exit_bad_input);
    }
    dataset.splits.pairs["test"].clear();
    test::write_small_dataset(folder.path(), dataset);
    SampleInputs empty;
    CHECK(read(empty, {splits}) == exit_bad_input);
}

TEST_CASE_METHOD(Fixture, "Where there is no pose file, poses are made, for one body or for all")
{
    int made = 0;
    const auto read_made = [&](SampleInputs& inputs, std::vector<std::string> arguments) {
        Tool tool("test-inputs", "Reads inputs.", "test-inputs");
        inputs.add_files(tool, [&](const Template& body_template) {
            CHECK(body_template.num_prisms() == dataset.body_template.num_prisms());
            ++made;
            PoseSet poses = dataset.poses;
            poses.poses.resize(3);
            return poses;
        });
        inputs.add_samples(tool);
        arguments.insert(arguments.begin(), {"test-inputs", "--template=" + folder.file("template.h5"),
                                             "--bodies=" + folder.file("bodies.h5")});
        std::vector<char*> words;
        for (std::string& argument : arguments) words.push_back(argument.data());
        return tool.run(int(words.size()), words.data(), [&] { inputs.read(); });
    };
    SampleInputs all, one, file, splits;
    REQUIRE(read_made(all, {}) == exit_done);
    CHECK(all.samples.pairs.size() == 4 * 3);
    CHECK(all.samples.pairs[3] == SamplePair{1, 0});
    CHECK_FALSE(all.has_pose_file());
    REQUIRE(read_made(one, {"--body=2", "--pose=1"}) == exit_done);
    CHECK(one.samples.pairs == std::vector<SamplePair>{{2, 1}});
    CHECK(made == 2);
    REQUIRE(read_made(file, {"--body=2", "--poses=" + folder.file("poses.h5")}) == exit_done);
    CHECK(file.samples.size() == dataset.poses.size());
    CHECK(made == 2);
    CHECK(read_made(splits, {"--splits=" + folder.file("splits.h5")}) == exit_bad_input);
}
