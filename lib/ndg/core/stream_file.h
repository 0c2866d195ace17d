// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <ostream>
#include <string>

namespace ndg {

/// write_file (core/file.h) for what `write` puts into the file piece by piece: a reader sees the old content or the
/// new one. Where `write` throws, or the disk is full, nothing is left. Throws Error.
void write_stream(const std::string& path, const std::function<void(std::ostream& stream)>& write);

}  // namespace ndg
