// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/run_batch.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/progress.h"
#include "ndg/core/threads.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>

namespace ndg {

namespace {

/// CHOLMOD opens parallel sections of four threads of its own; within items that run side by side they would only wait
/// for each other. Lets `levels` nested sections run in parallel until the end of the scope.
class ParallelLevels {
public:
    explicit ParallelLevels(int levels) : previous_(omp_get_max_active_levels()) { omp_set_max_active_levels(levels); }
    ~ParallelLevels() { omp_set_max_active_levels(previous_); }
    ParallelLevels(const ParallelLevels&) = delete;
    ParallelLevels& operator=(const ParallelLevels&) = delete;

private:
    int previous_;
};

/// Items without a part.
std::vector<int> open_items(const PartStore& store, const Batch& batch)
{
    std::vector<int> open;
    for (std::size_t i = 0; i < batch.items.size(); ++i) {
        const std::optional<std::string> failure = store.find(batch.items[i], batch.read);
        if (!failure) {
            open.push_back(static_cast<int>(i));
        } else if (!failure->empty()) {
            log_warning("{} failed in an earlier run: {}", batch.items[i].label, *failure);
        }
    }
    return open;
}

void make_item(const PartStore& store, const BatchItem& item, int item_idx, const BatchWorker& worker)
{
    PartWriter payload;
    std::string failure;
    try {
        payload = worker(item_idx);
    } catch (const InputError&) {
        throw;
    } catch (const Interrupted&) {
        throw;
    } catch (const Error& error) {
        failure = error.what();
    }
    if (failure.empty()) {
        store.write(item, payload);
    } else {
        log_warning("{} failed: {}", item.label, failure);
        store.write_failure(item, failure);
    }
}

}  // namespace

int run_batch(const PartStore& store, const Batch& batch, const std::function<bool()>& stop)
{
    const std::vector<int> open = open_items(store, batch);
    const std::size_t num_stored = batch.items.size() - open.size();
    if (num_stored > 0) {
        log_info("{} of {} {} stand already in {}", num_stored, batch.items.size(), store.kind().items, store.path());
    }
    Progress progress(batch.task, open.size());
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stopped{false};
    std::mutex mutex;
    std::exception_ptr first_exception;
    const int threads = std::max(1, std::min(num_threads(), static_cast<int>(open.size())));
    const ParallelLevels levels(threads > 1 || (batch.lone_item_parallel && batch.items.size() == 1) ? 1 : 0);
#pragma omp parallel num_threads(threads)
    try {
        BatchWorker worker;
        while (!stopped) {
            if (next >= open.size()) break;
            if (stop()) stopped = true;
            const std::size_t place = stopped ? open.size() : next++;
            if (place >= open.size()) break;
            if (!worker) worker = batch.make_worker();
            make_item(store, batch.items[open[place]], open[place], worker);
            progress.advance();
        }
    } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!first_exception) first_exception = std::current_exception();
        stopped = true;
    }
    if (first_exception) std::rethrow_exception(first_exception);
    if (stopped) {
        throw Interrupted(fmt::format("interrupted; finished {} are kept in {}, the same command goes on from there",
                                      store.kind().items, store.path()));
    }
    return static_cast<int>(num_stored);
}

}  // namespace ndg
