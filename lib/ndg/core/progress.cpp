// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/progress.h"

#include "ndg/core/log.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <utility>

namespace ndg {
namespace {

using Clock = std::chrono::steady_clock;

std::string format_seconds(double seconds)
{
    const auto whole = static_cast<long long>(seconds + 0.5);
    if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

struct Progress::State {
    std::string task;
    std::size_t total = 0;
    std::size_t done = 0;
    bool terminal = false;
    bool shown = false;
    Clock::time_point start = Clock::now();
    Clock::time_point last_report = start;
    std::mutex mutex;

    double seconds_between_reports() const { return terminal ? 0.1 : 5.0; }

    void report()
    {
        if (!log_enabled(LogLevel::info)) return;
        const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
        const double rate = elapsed > 0 ? static_cast<double>(done) / elapsed : 0.0;
        std::string text = fmt::format("{} {}/{}", task, done, total);
        if (rate > 0) {
            text += fmt::format(", {:.3g}/s", rate);
            if (done < total)
                text += fmt::format(", {} left", format_seconds(static_cast<double>(total - done) / rate));
        }
        if (!terminal) {
            log_message(LogLevel::info, text);
        } else {
            constexpr std::size_t width = 24;
            const std::size_t filled = total > 0 ? std::min(width, width * done / total) : width;
            const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
            std::fprintf(stderr, "\r\033[K[%s] %s", bar.c_str(), text.c_str());
            std::fflush(stderr);
        }
        shown = true;
    }
};

Progress::Progress(std::string task, std::size_t total) : state_(std::make_unique<State>())
{
    state_->task = std::move(task);
    state_->total = total;
    state_->terminal = isatty(STDERR_FILENO) != 0;
}

Progress::~Progress()
{
    const std::lock_guard<std::mutex> lock(state_->mutex);
    try {
        // A task that ended before its first report is not worth a line.
        if (state_->shown) state_->report();
    } catch (...) {  // a destructor may run while another error is on its way
        return;
    }
    if (state_->shown && state_->terminal) std::fputc('\n', stderr);
}

void Progress::advance(std::size_t count)
{
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->done += count;
    const auto now = Clock::now();
    if (std::chrono::duration<double>(now - state_->last_report).count() < state_->seconds_between_reports()) return;
    state_->last_report = now;
    state_->report();
}

}  // namespace ndg
