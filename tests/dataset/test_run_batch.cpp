// SPDX-License-Identifier: Apache-2.0
// Batches of toy items: interruption, failures, exceptions, parts of other keys and damaged ones.
#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/dataset/run_batch.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <new>

using namespace ndg;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

const auto never = [] { return false; };
const PartKind square_parts = {"test-square-part", 1, "squares"};

/// Squares of the numbers 0 to 9, where 7 fails.
struct Squares {
    test::TemporaryFolder folder;
    std::string output = folder.file("squares.h5");
    Batch batch;
    std::atomic<int> made{0}, workers{0};

    Squares()
    {
        set_num_threads(1);
        batch.task = "squaring";
        for (int i = 0; i < 10; ++i) {
            const std::string name = std::to_string(i);
            batch.items.push_back({name, "number " + name, "number " + name});
        }
        batch.read = [](const H5Reader& part) { part.read_ints("/square", 1, 0, 100); };
        batch.make_worker = [this]() -> BatchWorker {
            ++workers;
            return [this](int i) -> PartWriter {
                ++made;
                require(i != 7, "seven is no number");
                return [i](H5Writer& part) { part.write("/square", std::vector<int>{i * i}, "square"); };
            };
        };
    }
    std::string part(int i) const { return output + ".parts/" + std::to_string(i) + ".h5"; }
    /// All results; -1 for a failure.
    std::vector<int> results(const PartStore& store) const
    {
        std::vector<int> squares;
        for (const BatchItem& item : batch.items) {
            squares.push_back(-1);
            const std::string failure = store.read(
                item, [&](const H5Reader& file) { squares.back() = file.read_ints("/square", 1, 0, 100)[0]; });
            CHECK(failure == (squares.back() < 0 ? "seven is no number" : ""));
        }
        return squares;
    }
};

const std::vector<int> expected = {0, 1, 4, 9, 16, 25, 36, -1, 64, 81};

}  // namespace

TEST_CASE("A batch gives the same with one thread and several, and finds its failures again")
{
    for (const int threads : {1, 2, 5}) {
        Squares squares;
        set_num_threads(threads);
        const PartStore store(squares.output, square_parts, "key", false);
        CHECK(run_batch(store, squares.batch, never) == 0);
        CHECK(squares.made == 10);
        CHECK(squares.workers >= 1);
        CHECK(squares.workers <= threads);
        CHECK(squares.results(store) == expected);
        CHECK(run_batch(store, squares.batch, [] { return true; }) == 10);
        CHECK(squares.made == 10);
        const std::optional<PartsStatus> status = parts_status(squares.output);
        REQUIRE(status);
        CHECK(status->done == 9);
        CHECK(status->failed == 1);
        CHECK(status->running);
        store.remove();
        CHECK_FALSE(parts_status(squares.output));
    }
    set_num_threads(1);
}

TEST_CASE("An interrupted batch keeps what is finished and goes on from there")
{
    Squares squares;
    {
        const PartStore store(squares.output, square_parts, "key", false);
        int asked = 0;
        CHECK_THROWS_WITH(run_batch(store, squares.batch, [&] { return ++asked > 4; }),
                          Contains("finished squares are kept") && Contains(squares.output + ".parts"));
    }
    CHECK(squares.made == 4);
    CHECK_FALSE(parts_status(squares.output)->running);
    fs::copy_file(squares.part(0), squares.part(9) + ".123.tmp");  // as a killed process leaves it
    const PartStore store(squares.output, square_parts, "key", false);
    CHECK_FALSE(fs::exists(squares.part(9) + ".123.tmp"));
    CHECK(run_batch(store, squares.batch, never) == 4);
    CHECK(squares.made == 10);
    CHECK(squares.results(store) == expected);
}

TEST_CASE("Exceptions that are no item's own end the batch, and leave the parallel section")
{
    Squares squares;
    set_num_threads(2);
    const auto batch_that_throws = [&](const auto& error) {
        Batch batch = squares.batch;
        const BatchWorker square = batch.make_worker();
        batch.make_worker = [square, error] {
            return [square, error](int i) -> PartWriter {
                if (i == 5) throw error;
                return square(i);
            };
        };
        return batch;
    };
    {
        const PartStore store(squares.output, square_parts, "key", false);
        CHECK_THROWS_AS(run_batch(store, batch_that_throws(InputError("wrong file")), never), InputError);
        CHECK_THROWS_AS(run_batch(store, batch_that_throws(Interrupted("stopped inside")), never), Interrupted);
        CHECK_THROWS_AS(run_batch(store, batch_that_throws(std::bad_alloc()), never), std::bad_alloc);
        CHECK_FALSE(fs::exists(squares.part(5)));
        CHECK(fs::exists(squares.part(4)));
        Batch batch = squares.batch;
        batch.make_worker = []() -> BatchWorker { throw InputError("no worker"); };
        CHECK_THROWS_WITH(run_batch(store, batch, never), "no worker");
        CHECK(run_batch(store, squares.batch, never) >= 5);
        CHECK(squares.results(store) == expected);
    }
    set_num_threads(1);
}

TEST_CASE("Parts that are damaged, of another item or of a worker that stopped half-way are made again")
{
    Squares squares;
    const PartStore store(squares.output, square_parts, "key", false);
    run_batch(store, squares.batch, never);
    fs::resize_file(squares.part(2), fs::file_size(squares.part(2)) / 2);
    fs::copy_file(squares.part(3), squares.part(4), fs::copy_options::overwrite_existing);
    squares.batch.items[5].identity = "another five";
    CHECK(run_batch(store, squares.batch, never) == 7);
    CHECK(squares.made == 13);
    CHECK(squares.results(store) == expected);
    fs::remove(squares.part(8));
    CHECK_THROWS_WITH(squares.results(store), Contains("number 8 cannot be read back"));

    const BatchItem item = {"half", "half", "half"};
    CHECK_THROWS_AS(store.write(item, [](H5Writer&) { throw Error("no more"); }), Error);
    CHECK_FALSE(store.find(item, [](const H5Reader&) {}));
}

TEST_CASE("One process at a time, and parts of another key are refused or set aside")
{
    Squares squares;
    {
        const PartStore store(squares.output, square_parts, "key", false);
        CHECK_THROWS_WITH(PartStore(squares.output, square_parts, "key", false),
                          Contains("is at these squares already") && Contains(std::to_string(::getpid())));
        CHECK_THROWS_AS(PartStore(squares.output, square_parts, "key", true), InputError);
        run_batch(store, squares.batch, never);
    }
    CHECK_THROWS_WITH(PartStore(squares.output, square_parts, "another key", false),
                      Contains("holds 10 squares") && Contains("--force"));
    {
        const PartStore store(squares.output, square_parts, "key", true);  // nothing to set aside
        CHECK(run_batch(store, squares.batch, never) == 10);
    }
    const PartStore store(squares.output, square_parts, "another key", true);
    const auto parts_in = [](const std::string& folder) {
        return std::distance(std::filesystem::directory_iterator(folder), {});
    };
    CHECK(parts_in(squares.output + ".parts.1") == 10);
    CHECK(run_batch(store, squares.batch, never) == 0);
    CHECK(squares.results(store) == expected);

    std::ofstream(squares.folder.file("blocked.parts")).flush();
    CHECK_THROWS_AS(PartStore(squares.folder.file("blocked"), square_parts, "key", false), InputError);
}
