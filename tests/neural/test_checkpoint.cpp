// SPDX-License-Identifier: Apache-2.0
// Checkpoints on disk, written while training goes on.
#include "ndg/neural/checkpoint.h"

#include "ndg/core/error.h"
#include "support/support.h"

#include <torch/utils.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

namespace {

Checkpoint some_checkpoint()
{
    Checkpoint checkpoint;
    checkpoint.fingerprint = "run";
    checkpoint.epoch = 3;
    checkpoint.batch = 5;
    checkpoint.loss_sum = 0.125;
    checkpoint.neutral_sum = 0.3;
    checkpoint.num_steps = 77;
    checkpoint.curve.epoch = {1, 2, 3};
    checkpoint.curve.train_loss = checkpoint.curve.validation_loss = {3, 2, 1};
    torch::manual_seed(1);
    for (auto list : {&Checkpoint::parameters, &Checkpoint::first_moments, &Checkpoint::second_moments,
                      &Checkpoint::averages, &Checkpoint::best_parameters, &Checkpoint::bases})
        checkpoint.*list = {torch::randn({300, 200}), torch::randn({200})};
    return checkpoint;
}

}  // namespace

TEST_CASE("a checkpoint holds the moment it was started in, whatever training does meanwhile")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("checkpoint");
    Checkpoint state = some_checkpoint();
    CheckpointWriter writer(path);
    CHECK(writer.seconds() == 0);
    for (int round = 0; round < 3; ++round) {
        std::vector<torch::Tensor> expected;
        for (const torch::Tensor& tensor : state.parameters) expected.push_back(tensor.clone());
        const torch::Tensor moment = state.second_moments[0].clone();
        writer.start(state);
        for (int step = 0; step < 100; ++step) {
            for (torch::Tensor& tensor : state.parameters) tensor.add_(1);
            state.second_moments[0].mul_(1.1);
        }
        ++state.epoch;
        writer.finish();
        CHECK(!writer.busy());
        CHECK(writer.seconds() > 0);
        const Checkpoint read = read_checkpoint(path);
        CHECK(read.epoch == 3 + round);
        CHECK(read.neutral_sum == 0.3);
        REQUIRE(read.parameters.size() == 2);
        for (std::size_t i = 0; i < 2; ++i) {
            CHECK(torch::equal(read.parameters[i], expected[i]));
            CHECK(torch::equal(read.best_parameters[i], state.best_parameters[i]));
        }
        CHECK(torch::equal(read.second_moments[0], moment));
        CHECK(!std::filesystem::exists(path + ".tmp"));
    }
}

TEST_CASE("a checkpoint that could not be written is said by the next call")
{
    const TemporaryFolder folder;
    CheckpointWriter writer(folder.file("missing/checkpoint"));
    writer.start(some_checkpoint());
    CHECK_THROWS_AS(writer.finish(), Error);
    CHECK_NOTHROW(writer.finish());
    writer.start(some_checkpoint());
    CHECK_THROWS_AS(writer.start(some_checkpoint()), Error);
}

TEST_CASE("a damaged checkpoint is refused, one that memory does not suffice for is not called damaged")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("checkpoint");
    Checkpoint state = some_checkpoint();
    state.parameters = {torch::zeros({50'000'000})};
    state.first_moments = state.second_moments = {torch::zeros({10})};
    write_checkpoint(path, state);
    enum { read = 0, said_memory, called_damaged, something_else };
    const auto outcome = [&](rlim_t more_bytes) {
        const pid_t child = fork();
        if (child == 0) {
            long pages = 0;
            std::ifstream("/proc/self/statm") >> pages;
            const rlim_t limit = static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + more_bytes;
            const rlimit bounds{limit, limit};
            setrlimit(RLIMIT_AS, &bounds);
            int result = something_else;
            try {
                read_checkpoint(path);
                result = read;
            } catch (const InputError&) {
                result = called_damaged;
            } catch (const Error& error) {
                const bool names = std::string(error.what()).find("not enough memory") != std::string::npos;
                result = names ? said_memory : something_else;
            } catch (...) {
            }
            _exit(result);
        }
        int status = -1;
        waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    };
    CHECK(outcome(2'000'000'000) == read);
    CHECK(outcome(100'000'000) == said_memory);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    CHECK_THROWS_AS(read_checkpoint(path), InputError);
}

TEST_CASE("a disk that fills up while a checkpoint is written is an error, and nothing is left")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("checkpoint");
    const pid_t child = fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit bounds{100'000, 100'000};
        setrlimit(RLIMIT_FSIZE, &bounds);
        int result = 1;
        try {
            write_checkpoint(path, some_checkpoint());
        } catch (const Error& error) {
            result = std::string(error.what()).find("File too large") == std::string::npos ? 2 : 0;
        } catch (...) {
            result = 3;
        }
        _exit(result);
    }
    int status = -1;
    waitpid(child, &status, 0);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    CHECK(!std::filesystem::exists(path));
    CHECK(!std::filesystem::exists(path + ".tmp"));
}
