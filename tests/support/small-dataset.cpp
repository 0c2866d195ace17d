// SPDX-License-Identifier: Apache-2.0
// small-dataset FOLDER RINGS SEGMENTS: writes the files of a small dataset, for tests that run tools as processes.
#include "ndg/core/error.h"
#include "support/small_dataset.h"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv)
{
    if (argc != 4) {
        std::fprintf(stderr, "usage: small-dataset FOLDER RINGS SEGMENTS\n");
        return ndg::exit_bad_input;
    }
    try {
        ndg::test::write_small_dataset(argv[1], ndg::test::small_dataset(std::atoi(argv[2]), std::atoi(argv[3])));
    } catch (const ndg::Error& error) {
        std::fprintf(stderr, "small-dataset: %s\n", error.what());
        return ndg::exit_failed;
    }
    return 0;
}
