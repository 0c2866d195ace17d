// SPDX-License-Identifier: Apache-2.0
// Arrays of a NumPy archive: a zip file of .npy files, as numpy.savez and numpy.savez_compressed write it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace ndg {

struct NpyArray {
    std::vector<std::int64_t> shape;  ///< empty for a single number
    std::vector<double> values;       ///< in C order
};

/// Reads an archive; entries are unpacked when asked for. Sizes are checked against the file before memory is taken.
class NpzFile {
public:
    /// Throws InputError naming the file: missing, no zip archive, truncated, encrypted, larger than 4 GiB.
    explicit NpzFile(const std::string& path);

    const std::string& path() const { return path_; }
    bool has(const std::string& key) const { return entries_.count(key) > 0; }
    /// float32, float64 or integers in C order, little-endian. Throws InputError naming file, key and value: missing
    /// key, wrong checksum, other type (pickled objects among them), size that does not match the shape, non-finite.
    NpyArray read(const std::string& key) const;

private:
    struct Entry {
        unsigned method = 0;  ///< 0 stored, 8 deflated
        std::uint32_t checksum = 0;
        std::size_t packed_size = 0, size = 0, header = 0;
    };
    std::string unpack(const std::string& key) const;

    std::string path_;
    std::string bytes_;
    std::map<std::string, Entry> entries_;  ///< by name without ".npy"
};

}  // namespace ndg
