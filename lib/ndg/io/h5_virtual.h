// SPDX-License-Identifier: Apache-2.0
// Datasets whose slices lie in other HDF5 files (HDF5's virtual datasets).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ndg {

/// A file that holds slices of a virtual dataset, in a dataset of the same name.
struct VirtualSource {
    std::string path;                 ///< relative to the folder of the virtual dataset's file
    std::size_t num_slices = 0;       ///< that the source's dataset has
    std::vector<std::size_t> slices;  ///< of the source, in the order of `places`
    std::vector<std::size_t> places;  ///< where they stand in the virtual dataset; ascending
};

/// Paths of the files a dataset's slices lie in, as the dataset names them, each once; empty if it is not virtual.
/// Throws InputError if there is no such dataset.
std::vector<std::string> virtual_sources(const std::string& path, const std::string& name);

}  // namespace ndg
