// SPDX-License-Identifier: Apache-2.0
// Compiled for every x86-64 processor (CMakeLists.txt), whatever the rest is compiled for.
#include "ndg/core/processor.h"

#include <unistd.h>

#include <string_view>

namespace ndg {

namespace {

constexpr char architecture[] = NDG_ARCH;

#ifdef __x86_64__
/// Before any other code of ours: that may use the instructions asked for here.
__attribute__((constructor(101))) void require_processor()
{
    if (std::string_view(architecture) != "x86-64-v3") return;
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return;
    constexpr char message[] =
        "error: this program was built for processors with AVX2 and FMA (x86-64-v3), which this one is not; build it "
        "with cmake -DNDG_ARCH=x86-64\n";
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message, sizeof message - 1);
    ::_exit(1);
}
#endif

}  // namespace

std::string processor_name()
{
    return architecture;
}

}  // namespace ndg
