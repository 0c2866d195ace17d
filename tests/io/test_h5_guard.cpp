// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/h5_guard.h"

#include "ndg/core/file.h"
#include "ndg/io/h5.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <functional>

using namespace ndg;

namespace {

struct Ending {
    int exit_code = -1, signal = 0;
    std::string text;  ///< of stderr
};

/// What becomes of a process that does this.
Ending ending_of(const std::function<void()>& work)
{
    int pipe[2];
    REQUIRE(::pipe(pipe) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(pipe[1], STDERR_FILENO);
        for (const int signal : {SIGSEGV, SIGBUS, SIGFPE}) ::signal(signal, SIG_DFL);  // not the test program's
        work();
        ::_exit(0);
    }
    ::close(pipe[1]);
    Ending ending;
    char buffer[256];
    for (ssize_t count = 0; (count = ::read(pipe[0], buffer, sizeof buffer)) > 0;) ending.text.append(buffer, count);
    ::close(pipe[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFEXITED(status)) ending.exit_code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) ending.signal = WTERMSIG(status);
    return ending;
}

[[gnu::noinline]] int use_up_stack(volatile int* depth)
{
    volatile char space[4096] = {};
    if (++*depth > 1000000000) return 0;
    return space[0] + use_up_stack(depth) + *depth;
}

}  // namespace

TEST_CASE("a fault while HDF5 reads a file ends the process with one line that names the file")
{
    for (const bool by_stack : {false, true}) {
        const Ending ending = ending_of([by_stack] {
            const h5::ReadingGuard outer("outer.h5");
            const h5::ReadingGuard guard("damaged.h5");
            volatile int depth = 0;
            if (by_stack) use_up_stack(&depth);
            ::raise(SIGSEGV);
        });
        INFO(ending.text);
        CHECK(ending.exit_code == 2);
        CHECK_THAT(ending.text, Catch::Contains("error: damaged.h5: is damaged"));
        CHECK(std::count(ending.text.begin(), ending.text.end(), '\n') == 1);
    }
}

TEST_CASE("so does a heap that the library has overwritten")
{
    const Ending ending = ending_of([] {
        ::signal(SIGABRT, SIG_DFL);
        const h5::ReadingGuard guard("damaged.h5");
        std::abort();
    });
    CHECK(ending.exit_code == 2);
    CHECK_THAT(ending.text, Catch::Contains("error: damaged.h5: is damaged"));
}

TEST_CASE("a fault anywhere else is a fault")
{
    const Ending ending = ending_of([] {
        {
            const h5::ReadingGuard guard("sound.h5");
        }
        ::raise(SIGSEGV);
    });
    CHECK(ending.signal == SIGSEGV);
    CHECK(ending.text.empty());
}

TEST_CASE("looking through a file without end is told, then ended")
{
    const Ending ending = ending_of([] {
        h5::set_lookup_limits(0.1, 0.4);
        const h5::ReadingGuard guard("circle.h5");
        ::sleep(20);
    });
    INFO(ending.text);
    CHECK(ending.exit_code == 2);
    CHECK_THAT(ending.text, Catch::Contains("circle.h5: still looking") && Catch::Contains("circle.h5: is damaged"));
    // Reading what a sound file holds may take as long as it does.
    const Ending sound = ending_of([] {
        h5::set_lookup_limits(0.1, 0.4);
        const h5::ReadingGuard guard("large.h5", false);
        ::usleep(800000);
    });
    CHECK(sound.exit_code == 0);
    CHECK(sound.text.empty());
}
