// SPDX-License-Identifier: Apache-2.0
// Many items by several threads, resumable: what simulate-fem, build-layers and fit-body have in common.
#pragma once

#include "ndg/dataset/part_store.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// Makes an item and returns what writes its part. Throws Error where this item cannot be made; InputError and
/// Interrupted end the whole batch.
using BatchWorker = std::function<PartWriter(int item_idx)>;

struct Batch {
    std::string task;  ///< of the progress report, e.g. "simulating"
    std::vector<BatchItem> items;
    std::function<BatchWorker()> make_worker;  ///< called by each thread for its own
    PartReader read;                           ///< checks a part of an earlier run
    bool lone_item_parallel = false;           ///< an item that is alone may use all threads itself
};

/// Makes every item that the store does not hold, one item a thread, in order; afterwards PartStore::read gives them
/// all. An item that cannot be made is stored as a failure, with a warning. What is stored does not depend on threads
/// or interruptions. Returns how many were there already. Throws Interrupted, the parts kept, once `stop` returns true
/// (asked before each item), and the first exception that ends the batch.
int run_batch(const PartStore& store, const Batch& batch, const std::function<bool()>& stop);

}  // namespace ndg
