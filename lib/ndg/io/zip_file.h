// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace ndg {

/// An unsigned number of `num_bytes` at most four, least significant first, as zip and .npy files hold them.
std::uint32_t number_at(std::string_view bytes, std::size_t at, int num_bytes);

/// A zip archive, as numpy.savez and torch.save write it. Entries are unpacked when asked for; sizes are checked
/// against the file before memory is taken.
class ZipFile {
public:
    struct Entry {
        unsigned method = 0;  ///< 0 stored, 8 deflated
        std::uint32_t checksum = 0;
        std::size_t packed_size = 0, size = 0, header = 0;
    };

    /// Throws InputError naming the file: missing, no zip archive, truncated, encrypted, larger than 4 GiB.
    explicit ZipFile(const std::string& path);

    const std::string& path() const { return path_; }
    const std::map<std::string, Entry>& entries() const { return entries_; }  ///< by name
    bool has(const std::string& name) const { return entries_.count(name) > 0; }
    /// Content of an entry. Throws InputError, beginning with `item`, where it is broken or its checksum is another.
    std::string unpack(const std::string& name, const std::string& item) const;

private:
    std::string path_;
    std::string bytes_;
    std::map<std::string, Entry> entries_;
};

}  // namespace ndg
