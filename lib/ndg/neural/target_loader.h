// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): targets of the batches to come, made while a step runs.
#pragma once

#include "ndg/neural/options.h"

#include <torch/types.h>

#include <functional>
#include <future>
#include <vector>

namespace ndg {

/// Goes through some samples in batches, one batch ahead of its user, on threads of its own: as many as there
/// are for a step, so that neither waits long for the other. With num_threads() of 1: nothing runs ahead.
class TargetLoader {
public:
    /// Writes the target of a sample; called by several threads at once.
    using MakeTarget = std::function<void(int sample_idx, float* target)>;

    /// Batches of `order` from number `first_batch` on; the last may be smaller. `width`: numbers of a target. For a
    /// device other than the CPU they lie in page-locked memory, from which they are copied at full speed.
    TargetLoader(MakeTarget make_target, int width, std::vector<int> order, int batch_size, int first_batch,
                 Device device);
    /// Waits for what was begun.
    ~TargetLoader();

    struct Batch {
        std::vector<int> samples;
        torch::Tensor targets;  ///< samples x width, on the CPU
    };
    /// The next batch; not to be asked for more than there are. Throws what making a target throws.
    Batch next();

private:
    struct Pending : Batch {
        std::vector<std::future<void>> parts;
    };
    void begin();

    MakeTarget make_target_;
    std::int64_t width_;
    std::vector<int> order_;
    std::size_t batch_size_, position_;
    bool page_locked_;
    Pending ahead_;
};

}  // namespace ndg
