// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/threads.h"

#include "ndg/core/error.h"

#include <omp.h>

extern "C" void openblas_set_num_threads(int count);

namespace ndg {

void set_num_threads(int count)
{
    require_input(count >= 0, "number of threads must be 0 (all cores) or more, got {}", count);
    omp_set_num_threads(count > 0 ? count : omp_get_num_procs());
    // Threads of BLAS inside parallel sections would compete, and its threaded sums depend on their number.
    openblas_set_num_threads(1);
}

int num_threads()
{
    return omp_get_max_threads();
}

}  // namespace ndg
