// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>

namespace ndg {

/// Calls f(0), ..., f(count - 1) on all OpenMP threads, in no order. An exception of one call leaves the others
/// undisturbed and is thrown again at the end; of several, one.
template <typename F>
void parallel_for(int count, const F& f)
{
    std::exception_ptr failure;
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < count; ++i) {
        try {
            f(i);
        } catch (...) {
#pragma omp critical(ndg_parallel_for)
            failure = std::current_exception();
        }
    }
    if (failure) std::rethrow_exception(failure);
}

}  // namespace ndg
