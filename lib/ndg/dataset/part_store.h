// SPDX-License-Identifier: Apache-2.0
// Finished items of a batch beside its output, one file each, so that a run killed at any moment loses only what it was
// at. Every part has the attributes key, item and failure (empty: none) and, unless the item failed, what its own
// writer adds.
#pragma once

#include "ndg/io/h5.h"

#include <functional>
#include <mutex>
#include <optional>
#include <string>

namespace ndg {

/// One of what a batch makes.
struct BatchItem {
    std::string file;      ///< name of its part without ending, unique in the batch
    std::string identity;  ///< what the item depends on besides the batch's key; a part of another one is not used
    std::string label;     ///< in messages: "sample 3 (body 0 in pose 7)"
};

/// What is kept in a folder of parts.
struct PartKind {
    std::string format;  ///< of each part, e.g. "ndg-fem-part"
    int version = 1;
    std::string items;  ///< in messages, e.g. "samples"
};

/// Writes the payload of a part.
using PartWriter = std::function<void(H5Writer&)>;
/// Reads it; throws InputError for anything but a whole one.
using PartReader = std::function<void(const H5Reader&)>;

/// What the names of the files in a folder of parts tell, without opening any.
struct PartsStatus {
    int done = 0, failed = 0;  ///< items with a result; without one
    bool running = false;      ///< a process is at it now
    std::string process;       ///< "process 123 on host", of the last run
    double rate_hertz = 0;     ///< items a second since that run's start; 0: none yet
};
/// Of <output>.parts; nothing where there is no such folder.
std::optional<PartsStatus> parts_status(const std::string& output);

/// The folder <output>.parts, locked as long as the object lives, so that two processes do not do the same work.
/// write, write_failure and read may be called by several threads.
class PartStore {
public:
    /// `key`: all that the items depend on alike, the program's version included. Makes the folder, and removes what a
    /// killed run left half-written. Throws InputError when it cannot be made or written, another process is at it, or
    /// it holds parts of another key, unless `set_aside` moves those to <output>.parts.1 (or the next free number).
    PartStore(const std::string& output, const PartKind& kind, const std::string& key, bool set_aside);
    ~PartStore();
    PartStore(const PartStore&) = delete;
    PartStore& operator=(const PartStore&) = delete;

    /// Written under a temporary name and renamed. Throws Error (disk full, say).
    void write(const BatchItem& item, const PartWriter& payload) const;
    void write_failure(const BatchItem& item, const std::string& reason) const;
    /// Why the item failed, or "" after a call of `payload`. Nothing where there is no part, or it was of another key
    /// or item or damaged; then it is removed.
    std::optional<std::string> find(const BatchItem& item, const PartReader& payload) const;
    /// The same of an item that has been written. Throws Error where it cannot be read back.
    std::string read(const BatchItem& item, const PartReader& payload) const;
    /// Removes the folder and all parts.
    void remove() const;

    const std::string& path() const { return path_; }
    const PartKind& kind() const { return kind_; }

private:
    void write_part(const BatchItem& item, const std::string& failure, const PartWriter& payload) const;

    std::string path_, key_;
    PartKind kind_;
    mutable std::mutex mutex_;  ///< HDF5 is not thread-safe
    int lock_ = -1;
};

}  // namespace ndg
