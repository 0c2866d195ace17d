// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/hash.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/log.h"
#include "ndg/core/markup.h"
#include "ndg/core/progress.h"
#include "ndg/core/provenance.h"
#include "ndg/core/stream_file.h"
#include "ndg/core/text_file.h"
#include "ndg/core/threads.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <thread>

using namespace ndg;
using ndg::test::TemporaryFolder;

TEST_CASE("SHA-256 of FIPS 180-4's examples")
{
    CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
          "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    const TemporaryFolder folder;
    write_file(folder.file("million"), std::string(1000000, 'a'));
    CHECK(sha256_path(folder.file("million")) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a folder's hash follows names and contents, not order of creation")
{
    const TemporaryFolder one, two;
    std::filesystem::create_directory(one.file("sub"));
    std::filesystem::create_directory(two.file("sub"));
    write_file(one.file("a"), "1");
    write_file(one.file("sub/b"), "2");
    write_file(two.file("sub/b"), "2");
    write_file(two.file("a"), "1");
    CHECK(sha256_path(one.path()) == sha256_path(two.path()));
    const std::string before = sha256_path(two.path());
    std::filesystem::rename(two.file("a"), two.file("c"));
    CHECK(sha256_path(two.path()) != before);
    CHECK_THROWS_AS(sha256_path(one.file("missing")), InputError);
}

TEST_CASE("files are replaced whole and leave no temporary name")
{
    const TemporaryFolder folder;
    write_file(folder.file("x"), "old");
    write_file(folder.file("x"), std::string("new\0", 4));
    CHECK(read_file(folder.file("x")) == std::string("new\0", 4));
    CHECK_THROWS_AS(write_file(folder.file("no/such/folder"), ""), Error);
    std::filesystem::create_directories(folder.file("d/e"));
    CHECK_THROWS_WITH(write_file(folder.file("d"), "y"), Catch::Contains("is a folder"));
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) count += entry.exists() ? 1 : 0;
    CHECK(count == 2);
    CHECK_THROWS_WITH(read_file(folder.file("missing")), Catch::Contains("does not exist"));
    CHECK_THROWS_WITH(read_file(folder.path()), Catch::Contains("is a folder"));
}

TEST_CASE("a file written piece by piece is there whole or not at all")
{
    const TemporaryFolder folder;
    write_stream(folder.file("x"), [](std::ostream& stream) {
        stream << "one"
               << " two";
    });
    CHECK(read_file(folder.file("x")) == "one two");
    const auto breaks_off = [](std::ostream& stream) {
        stream << "half";
        throw Error("broken off");
    };
    CHECK_THROWS_WITH(write_stream(folder.file("x"), breaks_off), "broken off");
    CHECK(read_file(folder.file("x")) == "one two");
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
    CHECK_THROWS_AS(write_stream("/dev/full/x", [](std::ostream&) {}), Error);
}

TEST_CASE("what is written goes where links lead, and only to files")
{
    namespace fs = std::filesystem;
    const TemporaryFolder folder;
    fs::create_directory(folder.file("sub"));
    write_file(folder.file("sub/target"), "old");
    fs::create_symlink("sub/target", folder.file("link"));
    fs::create_symlink(folder.file("link"), folder.file("link to link"));
    write_file(folder.file("link to link"), "new");
    CHECK(read_file(folder.file("sub/target")) == "new");
    CHECK(fs::is_symlink(folder.file("link")));
    CHECK(fs::is_symlink(folder.file("link to link")));
    fs::create_symlink("sub/not yet", folder.file("forward"));
    write_file(folder.file("forward"), "made");
    CHECK(read_file(folder.file("sub/not yet")) == "made");
    fs::create_symlink("circle", folder.file("circle"));
    CHECK_THROWS_WITH(write_file(folder.file("circle"), ""), Catch::Contains("leads to itself"));

    REQUIRE(::mkfifo(folder.file("pipe").c_str(), 0666) == 0);
    fs::create_symlink("pipe", folder.file("to pipe"));
    for (const char* name : {"pipe", "to pipe"}) {
        CHECK_THROWS_WITH(write_file(folder.file(name), "x"), Catch::Contains("is a pipe or device"));
        CHECK_THROWS_WITH(read_file(folder.file(name)), Catch::Contains("is a pipe or device"));
    }
    CHECK(fs::is_fifo(folder.file("pipe")));
    CHECK_THROWS_WITH(write_file("/dev/null", "x"), Catch::Contains("is a pipe or device"));
    CHECK_THROWS_WITH(write_stream("/dev/null", [](std::ostream&) {}), Catch::Contains("is a pipe or device"));
    CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("texts of any origin become UTF-8 with line feeds")
{
    const auto normal = [](const std::string& content) { return normalise_text("x", content); };
    CHECK(normal("a\nb\n") == "a\nb\n");
    CHECK(normal("\xEF\xBB\xBF"
                 "a\r\nb\rc\r\r\n\x1A") == "a\nb\nc\n\n");
    CHECK(normal(std::string("a\n\0\0", 4)) == "a\n");
    CHECK(normal("na\xEFve") == "na\xC3\xAFve");  // Latin-1
    CHECK(normal("na\xC3\xAFve \xF0\x9F\xA6\xB4") == "na\xC3\xAFve \xF0\x9F\xA6\xB4");
    CHECK(normal("") == "");
    for (const std::string& wide :
         {std::string("\xFF\xFE"
                      "a\0",
                      4),
          std::string("\xFE\xFF\0a", 4), std::string("H\0I\0E\0R\0A\0", 10), std::string("\0H\0I\0E\0R\0A", 10)})
        CHECK_THROWS_WITH(normal(wide), "x: is text in UTF-16; save it as UTF-8");
    CHECK_THROWS_WITH(normal(std::string("\xFF\xFE\0\0a\0\0\0", 8)), Catch::Contains("UTF-32"));

    // Overlong forms, surrogates, what is beyond Unicode, what is cut off.
    for (const char* bytes : {"\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xC3", "\x80"})
        CHECK_FALSE(is_utf8(bytes));
    CHECK(printable("a\tb\x1B[31m \xC3\xAF \xEF \xC2\x9B") == "a?b?[31m \xC3\xAF ? ?");
    CHECK(equal_without_case("EndFacet", "endfacet"));
    CHECK_FALSE(equal_without_case("end", "endfacet"));
}

TEST_CASE("a folder with a name that is no text is refused by name")
{
    const TemporaryFolder folder;
    write_file(folder.file("J\xF6rg.bvh"), "x");
    CHECK_THROWS_WITH(sha256_path(folder.path()), Catch::Contains("is not UTF-8"));
}

TEST_CASE("text is escaped for markup")
{
    CHECK(escaped_markup("a < b & \"c\" > d") == "a &lt; b &amp; &quot;c&quot; &gt; d");
}

TEST_CASE("signals set a flag")
{
    CHECK_FALSE(interrupt_requested());
    catch_interrupts();
    std::raise(SIGUSR1);
    CHECK(interrupt_requested());
}

TEST_CASE("log levels and threads")
{
    set_log_level(LogLevel::error);
    CHECK_FALSE(log_enabled(LogLevel::info));
    CHECK(log_enabled(LogLevel::error));
    CHECK_FALSE(log_enabled(LogLevel::off));
    set_num_threads(2);
    CHECK(num_threads() == 2);
    set_num_threads(0);
    CHECK(num_threads() >= 1);
    CHECK_THROWS_AS(set_num_threads(-1), InputError);
}

TEST_CASE("progress may advance from several threads")
{
    Progress progress("test", 4000);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
        threads.emplace_back([&] {
            for (int i = 0; i < 1000; ++i) progress.advance();
        });
    }
    for (std::thread& thread : threads) thread.join();
}

TEST_CASE("version and commit are never empty")
{
    CHECK(project_version() == "0.1.0");
    CHECK_FALSE(project_commit().empty());
}
