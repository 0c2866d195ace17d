// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/file.h"

#include "ndg/core/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

namespace ndg {
namespace {

using FilePointer = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// fsync of a file or folder by name.
bool sync_path(const std::string& path, int flags)
{
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool synced = ::fsync(descriptor) == 0;
    const int error = errno;
    ::close(descriptor);
    errno = error;
    return synced;
}

}  // namespace

std::string read_file(const std::string& path)
{
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    require_input(std::filesystem::exists(status), "{}: does not exist", path);
    require_input(!std::filesystem::is_directory(status), "{}: is a folder, expected a file", path);
    // Whoever opens a pipe waits for someone to write.
    require_input(std::filesystem::is_regular_file(status), "{}: is a pipe or device, expected a file", path);
    const FilePointer file(std::fopen(path.c_str(), "rb"), std::fclose);
    require_input(file != nullptr, "{}: cannot open: {}", path, std::strerror(errno));
    std::string content;
    char buffer[1 << 16];
    std::size_t count = 0;
    while ((count = std::fread(buffer, 1, sizeof buffer, file.get())) > 0) content.append(buffer, count);
    require_input(std::ferror(file.get()) == 0, "{}: cannot read: {}", path, std::strerror(errno));
    return content;
}

void write_file(const std::string& path, std::string_view content)
{
    const std::string temporary_path = temporary_name(path);
    try {
        FilePointer file(std::fopen(temporary_path.c_str(), "wb"), std::fclose);
        require(file != nullptr, "{}: cannot create: {}", temporary_path, std::strerror(errno));
        const bool written = std::fwrite(content.data(), 1, content.size(), file.get()) == content.size();
        const bool closed = std::fclose(file.release()) == 0;
        require(written && closed, "{}: cannot write: {}", temporary_path, std::strerror(errno));
        replace_file(temporary_path, path);
    } catch (...) {
        ::unlink(temporary_path.c_str());
        throw;
    }
}

std::vector<std::string> numbered_names(const std::string& pattern, int count)
{
    std::vector<std::string> names;
    try {
        for (int i = 0; i < count; ++i) names.push_back(fmt::format(fmt::runtime(pattern), i));
    } catch (const fmt::format_error& error) {
        throw InputError(
            fmt::format("{}: the place of the number is written {{}} or {{:04}} ({})", pattern, error.what()));
    }
    return names;
}

std::string writing_path(const std::string& path)
{
    namespace fs = std::filesystem;
    constexpr int most_links = 40;  // as Linux has it
    fs::path target = path;
    std::error_code error;
    for (int i = 0; fs::is_symlink(fs::symlink_status(target, error)); ++i) {
        require_input(i < most_links, "{}: is a link that leads to itself", path);
        const fs::path next = fs::read_symlink(target, error);
        require_input(!error, "{}: is a link that cannot be read: {}", path, error.message());
        target = next.is_absolute() ? next : target.parent_path() / next;
    }
    const fs::file_status status = fs::status(target, error);
    require_input(!fs::exists(status) || fs::is_regular_file(status), "{}: is {}, and no file can be put in its place",
                  path, fs::is_directory(status) ? "a folder" : "a pipe or device");
    return target.string();
}

std::string temporary_name(const std::string& path)
{
    return fmt::format("{}.{}.tmp", writing_path(path), ::getpid());
}

void replace_file(const std::string& temporary_path, const std::string& given_path)
{
    const std::string path = writing_path(given_path);
    require(sync_path(temporary_path, O_RDONLY), "{}: cannot bring to disk: {}", temporary_path, std::strerror(errno));
    require(std::rename(temporary_path.c_str(), path.c_str()) == 0, "{}: cannot rename to {}: {}", temporary_path, path,
            std::strerror(errno));
    // Some file systems cannot sync folders; the rename itself is atomic without it.
    const auto folder = std::filesystem::path(path).parent_path();
    sync_path(folder.empty() ? "." : folder.string(), O_RDONLY | O_DIRECTORY);
}

}  // namespace ndg
