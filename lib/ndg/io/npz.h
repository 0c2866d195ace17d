// SPDX-License-Identifier: Apache-2.0
// Arrays of a NumPy archive: a zip file of .npy files, as numpy.savez and numpy.savez_compressed write it.
#pragma once

#include "ndg/io/zip_file.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ndg {

struct NpyArray {
    std::vector<std::int64_t> shape;  ///< empty for a single number
    std::vector<double> values;       ///< in C order
};

/// One array as numpy.save writes it. Types and errors as those of NpzFile::read; `finite` as there.
NpyArray read_npy(const std::string& path, bool finite = true);

/// Reads an archive; entries are unpacked when asked for. Sizes are checked against the file before memory is taken.
class NpzFile {
public:
    /// Throws InputError naming the file: missing, no zip archive, truncated, encrypted, larger than 4 GiB.
    explicit NpzFile(const std::string& path);

    const std::string& path() const { return zip_.path(); }
    bool has(const std::string& key) const { return zip_.has(key + ".npy"); }
    /// float32, float64 or integers, little-endian, in C or Fortran order. Throws InputError naming file, key and
    /// value: missing key, wrong checksum, other type (pickled objects among them), size that does not match the shape,
    /// non-finite.
    NpyArray read(const std::string& key) const { return read(key, true); }
    /// The same; `finite` false lets values through that are no numbers.
    NpyArray read(const std::string& key, bool finite) const;
    /// Names of the archive's arrays, sorted.
    std::vector<std::string> keys() const;

private:
    ZipFile zip_;
};

}  // namespace ndg
