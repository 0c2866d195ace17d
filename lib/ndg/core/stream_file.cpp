// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/stream_file.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace ndg {

void write_stream(const std::string& path, const std::function<void(std::ostream& stream)>& write)
{
    const std::string temporary_path = temporary_name(path);
    try {
        std::ofstream stream(temporary_path, std::ios::binary);
        require(stream.is_open(), "{}: cannot create: {}", temporary_path, std::strerror(errno));
        write(stream);
        stream.close();
        require(!stream.fail(), "{}: cannot write: {}", temporary_path, std::strerror(errno));
        replace_file(temporary_path, path);
    } catch (...) {
        ::unlink(temporary_path.c_str());
        throw;
    }
}

}  // namespace ndg
