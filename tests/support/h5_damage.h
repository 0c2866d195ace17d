// SPDX-License-Identifier: Apache-2.0
// Files as h5py sees them, and ways to damage them.
#pragma once

#include "ndg/core/provenance.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg::test {

/// Runs a Python script (h5py as h5py, numpy as np) and fails the test with its output if it fails.
void run_python(const std::string& script);

/// An edit of a file: Python statements on the open file `f` (`put(name, array)` replaces a dataset), and words that
/// the error must contain.
struct Damage {
    std::string python;
    std::vector<std::string> expected;
};
/// Every damage is done to a copy of the file; reading the copy must throw an InputError that names the copy and has
/// the expected words.
void check_damages(const std::string& path, const std::vector<Damage>& damages,
                   const std::function<void(const std::string&)>& read);

/// What the files of these tests are written with.
Provenance example_provenance();
/// Opens such a file by h5py and compares the attributes every file has and the shapes given as {"/path": (n, ...)}.
void check_by_h5py(const std::string& path, const std::string& format, const std::string& shapes, int version = 1);

}  // namespace ndg::test
