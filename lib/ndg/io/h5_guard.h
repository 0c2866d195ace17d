// SPDX-License-Identifier: Apache-2.0
// Private to io: what HDF5 does with damaged files. Its metadata hold addresses and counts that the library follows:
// with damaged ones it may read memory that is not there, or go in circles. Neither can be undone from within the
// process.
#pragma once

#include <string>

namespace ndg::h5 {

/// While one lives, a memory fault in its thread ends the process with exit code 2 and one line that names the file.
/// Where `looks_up` (opening, listing, attributes: work that takes milliseconds, however large a file is), it also says
/// so after ten seconds, and ends the process after a minute.
class ReadingGuard {
public:
    explicit ReadingGuard(std::string path, bool looks_up = true);
    ~ReadingGuard();
    ReadingGuard(const ReadingGuard&) = delete;
    ReadingGuard& operator=(const ReadingGuard&) = delete;

private:
    std::string path_;
    bool looks_up_;
    const char* outer_;  ///< path of the guard outside of this one
};

/// For tests: other times than ten seconds and a minute.
void set_lookup_limits(double say_after_s, double end_after_s);

}  // namespace ndg::h5
