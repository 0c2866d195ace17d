// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/blas_kernels.h"

#include <catch2/catch.hpp>

#include <cstdlib>
#include <string>

using namespace ndg;

TEST_CASE("OpenBLAS's kernels are replaced only where the processor has more than they use")
{
    CHECK(better_blas_kernels("Prescott", true, true) == "SkylakeX");
    CHECK(better_blas_kernels("Prescott", true, false) == "Haswell");
    CHECK(better_blas_kernels("Prescott", false, false).empty());
    for (const char* known : {"Haswell", "Zen", "SkylakeX", "Cooperlake", "SapphireRapids", "Sandybridge", "Nehalem"})
        CHECK(better_blas_kernels(known, true, true).empty());
}

TEST_CASE("a choice of the user's stands")
{
    ::setenv("OPENBLAS_CORETYPE", "Prescott", 1);
    char* no_arguments[] = {nullptr};
    restart_with_better_blas(no_arguments);  // comes back
    CHECK(std::string(std::getenv("OPENBLAS_CORETYPE")) == "Prescott");
    ::unsetenv("OPENBLAS_CORETYPE");
}
