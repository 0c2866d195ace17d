// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/blas_kernels.h"

#include "ndg/core/log.h"

#include <unistd.h>

#include <cstdlib>
#include <set>

extern "C" char* openblas_get_corename();

namespace ndg {

std::string better_blas_kernels(const std::string& core_name, bool has_avx2, bool has_avx512)
{
    static const std::set<std::string> sse_kernels = {"Katmai", "Coppermine", "Northwood", "Prescott",
                                                      "Banias", "Core2",      "Penryn",    "Dunnington"};
    if (sse_kernels.count(core_name) == 0) return "";
    if (has_avx512) return "SkylakeX";
    return has_avx2 ? "Haswell" : "";
}

void restart_with_better_blas(char** argv)
{
#ifdef __x86_64__
    constexpr const char* variable = "OPENBLAS_CORETYPE";
    if (std::getenv(variable)) return;
    const bool has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    const std::string chosen = openblas_get_corename();
    const std::string better = better_blas_kernels(chosen, has_avx2, has_avx512);
    if (better.empty() || ::setenv(variable, better.c_str(), 0) != 0) return;
    log_info("OpenBLAS does not know this processor and took its {} kernels: started anew with {}={}", chosen, variable,
             better);
    ::execv("/proc/self/exe", argv);
#else
    static_cast<void>(argv);
#endif
}

}  // namespace ndg
