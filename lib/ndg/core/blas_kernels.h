// SPDX-License-Identifier: Apache-2.0
// OpenBLAS chooses its kernels by the processor's model number. Of models newer than itself (Debian 12's 0.3.21 is of
// 2022) it knows nothing and takes kernels of 2004, half as fast and slower, whatever the processor can do.
#pragma once

#include <string>

namespace ndg {

/// Kernels that OpenBLAS should have taken: "SkylakeX", "Haswell", or "" where its own choice `core_name` stands (it
/// knew the processor, or the processor has no more).
std::string better_blas_kernels(const std::string& core_name, bool has_avx2, bool has_avx512);

/// To be called before anything is done by a program that spends time in BLAS. Where OpenBLAS took the wrong kernels:
/// says so and starts the program anew, once, with OPENBLAS_CORETYPE set, which OpenBLAS reads only at its start.
/// Where that is set already, by whomever, or the program cannot be started anew, it returns.
void restart_with_better_blas(char** argv);

}  // namespace ndg
