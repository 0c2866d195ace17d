// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/target_loader.h"

#include "ndg/core/error.h"
#include "ndg/core/threads.h"

#include <omp.h>

#include <algorithm>
#include <utility>

namespace ndg {

TargetLoader::TargetLoader(MakeTarget make_target, int width, std::vector<int> order, int batch_size, int first_batch,
                           Device device)
    : make_target_(std::move(make_target)),
      width_(width),
      order_(std::move(order)),
      batch_size_(static_cast<std::size_t>(batch_size)),
      position_(std::min(order_.size(), batch_size_ * static_cast<std::size_t>(first_batch))),
      page_locked_(device != Device::cpu)
{
    begin();
}

TargetLoader::~TargetLoader()
{
    for (std::future<void>& part : ahead_.parts)
        if (part.valid()) part.wait();
}

void TargetLoader::begin()
{
    ahead_ = Pending();
    const std::size_t end = std::min(order_.size(), position_ + batch_size_);
    ahead_.samples.assign(order_.begin() + static_cast<std::ptrdiff_t>(position_),
                          order_.begin() + static_cast<std::ptrdiff_t>(end));
    position_ = end;
    if (ahead_.samples.empty()) return;
    ahead_.targets = torch::empty({static_cast<std::int64_t>(ahead_.samples.size()), width_},
                                  torch::TensorOptions(torch::kFloat32).pinned_memory(page_locked_));
    float* targets = ahead_.targets.data_ptr<float>();
    const int parts = num_threads();
    for (int part = 0; part < parts; ++part) {
        const auto work = [this, targets, part, parts, samples = ahead_.samples] {
            omp_set_num_threads(1);
            for (std::size_t i = part; i < samples.size(); i += parts)
                make_target_(samples[i], targets + static_cast<std::int64_t>(i) * width_);
        };
        ahead_.parts.push_back(std::async(parts > 1 ? std::launch::async : std::launch::deferred, work));
    }
}

TargetLoader::Batch TargetLoader::next()
{
    require(!ahead_.samples.empty(), "A batch was asked for after the last");
    for (std::future<void>& part : ahead_.parts) part.get();
    Batch batch = std::move(ahead_);
    begin();
    return batch;
}

}  // namespace ndg
