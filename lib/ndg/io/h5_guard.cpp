// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/h5_guard.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"

#include <errno.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <list>
#include <mutex>
#include <thread>

namespace ndg::h5 {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the innermost guard of this thread; null outside of all.
thread_local const char* guarded_path = nullptr;

/// Calls nothing but write: a fault may come anywhere.
void write_line(const char* path, const char* text)
{
    for (const char* part : {static_cast<const char*>(program_invocation_short_name), ": error: ", path, text, "\n"}) {
        if (::write(STDERR_FILENO, part, std::strlen(part)) < 0) return;
    }
}

void end_at_fault(int signal)
{
    if (guarded_path != nullptr) {
        write_line(guarded_path, ": is damaged: the HDF5 library could not go on reading it");
        ::_exit(exit_bad_input);
    }
    ::signal(signal, SIG_DFL);  // a fault of our own: as if there were no handler
    ::raise(signal);
}

/// Others set handlers too, for a while: set anew whenever HDF5 is entered.
void catch_faults()
{
    // A stack of its own: circles in a file may use up the thread's.
    constexpr std::size_t stack_bytes = 1 << 16;
    thread_local char stack[stack_bytes];
    thread_local bool has_stack = false;
    if (!has_stack) {
        stack_t description = {};
        description.ss_sp = stack;
        description.ss_size = stack_bytes;
        ::sigaltstack(&description, nullptr);
        has_stack = true;
    }
    struct sigaction action = {};
    action.sa_handler = end_at_fault;
    action.sa_flags = SA_ONSTACK;
    // Abort: the C library's, where it finds its heap overwritten.
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT}) ::sigaction(signal, &action, nullptr);
}

/// Watches those that look something up, in a thread of its own. Lives as long as the process.
class Watch {
public:
    static Watch& get()
    {
        static Watch* const watch = new Watch;  // never destroyed: its thread may outlive main
        return *watch;
    }

    void set_limits(double say_after_s, double end_after_s)
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        say_after_ = std::chrono::duration<double>(say_after_s);
        end_after_ = std::chrono::duration<double>(end_after_s);
        running_ = false;  // the next lookup starts a thread that knows them; a forked process has none
    }
    void add(const ReadingGuard* guard, const std::string& path)
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        lookups_.push_front({guard, path, Clock::now(), false});
        if (running_) return;
        running_ = true;
        std::thread([this] { run(); }).detach();
    }
    void remove(const ReadingGuard* guard)
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        lookups_.remove_if([guard](const Lookup& lookup) { return lookup.guard == guard; });
    }

private:
    struct Lookup {
        const ReadingGuard* guard;
        std::string path;
        Clock::time_point since;
        bool said;
    };

    void run()
    {
        std::unique_lock<std::mutex> lock(mutex_);
        for (;;) {
            changed_.wait_for(lock, say_after_ / 4);  // never notified: a pause without the lock
            for (Lookup& lookup : lookups_) {
                const auto past = Clock::now() - lookup.since;
                if (past > end_after_) {
                    write_line(lookup.path.c_str(), ": is damaged: the HDF5 library found no end in it");
                    ::_exit(exit_bad_input);
                }
                if (past < say_after_ || lookup.said) continue;
                lookup.said = true;
                log_warning("{}: still looking through it; a sound file takes no second", lookup.path);
            }
        }
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::list<Lookup> lookups_;
    std::chrono::duration<double> say_after_{10}, end_after_{60};
    bool running_ = false;
};

}  // namespace

ReadingGuard::ReadingGuard(std::string path, bool looks_up)
    : path_(std::move(path)), looks_up_(looks_up), outer_(guarded_path)
{
    if (outer_ == nullptr) catch_faults();
    guarded_path = path_.c_str();
    // Guards within others are of the same lookup.
    looks_up_ = looks_up_ && outer_ == nullptr;
    if (looks_up_) Watch::get().add(this, path_);
}

ReadingGuard::~ReadingGuard()
{
    if (looks_up_) Watch::get().remove(this);
    guarded_path = outer_;
}

void set_lookup_limits(double say_after_s, double end_after_s)
{
    Watch::get().set_limits(say_after_s, end_after_s);
}

}  // namespace ndg::h5
