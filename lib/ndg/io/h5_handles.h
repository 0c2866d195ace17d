// SPDX-License-Identifier: Apache-2.0
// Private to io: HDF5 handles that close themselves, and translation of HDF5's errors and types.
#pragma once

#include "ndg/io/h5_virtual.h"

#include <hdf5.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace ndg::h5 {

/// Owns an HDF5 identifier; invalid (negative) ones are not closed.
class Handle {
public:
    using Close = herr_t (*)(hid_t);
    Handle() = default;
    Handle(hid_t id, Close close) : id_(id), close_(close) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle& operator=(Handle&& other) noexcept
    {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    ~Handle() { reset(); }

    operator hid_t() const { return id_; }
    bool valid() const { return id_ >= 0; }
    /// Closes now; false when HDF5 reports a failure (a flush, say).
    bool reset()
    {
        const hid_t id = std::exchange(id_, -1);
        return id < 0 || close_(id) >= 0;
    }

private:
    hid_t id_ = -1;
    Close close_ = nullptr;
};

/// Stops HDF5 from printing its error stack; to be called before the first operation in a thread.
void silence_errors();
/// Innermost description on HDF5's error stack.
std::string last_error();

/// An existing HDF5 file, read-only. Throws InputError: missing, not HDF5, truncated, locked.
Handle open_file(const std::string& path);
/// True if the path holds an HDF5 file that opens.
bool is_h5(const std::string& path);

/// Whether an absolute path exists, checking each of its components.
bool link_exists(hid_t file, const std::string& name);
/// Throws InputError naming file and dataset when there is no such dataset.
Handle open_dataset(hid_t file, const std::string& path, const std::string& name);
std::vector<std::size_t> dataset_shape(hid_t dataset);
/// Throws InputError where the header promises more data than the file can hold.
void check_stored_size(hid_t dataset, const std::string& path, const std::string& name);

/// A string attribute of an object; false when there is none or it is no text. Throws InputError if unreadable.
bool read_text_attribute(hid_t object, const std::string& path, const std::string& name, std::string& value);
/// All strings of a dataset, fixed or variable length.
std::vector<std::string> read_text_dataset(hid_t dataset, const std::string& path, const std::string& name);

/// "float32", "int32", "text"...
std::string type_name(hid_t type);

/// UTF-8 of variable length.
Handle text_type();
/// Replaces an attribute of that name; false where that fails.
bool write_text_attribute(hid_t object, const std::string& name, const std::string& value);
/// Creation properties of a float32 dataset over slices of `sources`. Throws Error, starting with `path`.
Handle virtual_creation(const std::string& path, const std::string& name, const std::vector<std::size_t>& shape,
                        const std::vector<VirtualSource>& sources);

}  // namespace ndg::h5
