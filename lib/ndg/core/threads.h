// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ndg {

/// Number of OpenMP threads for parallel sections; 0 means all cores. BLAS always runs on one thread.
void set_num_threads(int count);
int num_threads();

}  // namespace ndg
