// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool_files.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/text_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace ndg {
namespace {

namespace fs = std::filesystem;

/// Names go into files as text.
void check_name(const std::string& flag, const std::string& path)
{
    require_input(is_utf8(path), "{}: the name {} is not UTF-8; rename the file or folder", flag, path);
}

}  // namespace

std::vector<std::string> ToolInput::list() const
{
    if (const auto* many = std::get_if<std::vector<std::string>*>(&paths)) return **many;
    const std::string& one = **std::get_if<std::string*>(&paths);
    return one.empty() ? std::vector<std::string>{} : std::vector<std::string>{one};
}

void check_input(const ToolInput& input)
{
    const std::vector<std::string> paths = input.list();
    require_input(!input.required || !paths.empty(), "{} is missing", input.name());
    for (const std::string& path : paths) {
        require_input(!path.empty(), "{}: a file name is empty", input.name());
        std::error_code error;
        check_name(input.name(), path);
        const fs::file_status status = fs::status(path, error);
        require_input(fs::exists(status), "{}: {} does not exist", input.name(), path);
        require_input(fs::is_regular_file(status) || fs::is_directory(status),
                      "{}: {} is a pipe or device, expected a file", input.name(), path);
        require_input(::access(path.c_str(), R_OK) == 0, "{}: {} cannot be read", input.name(), path);
    }
}

void check_output(const ToolOutput& output, bool force)
{
    require_input(!output.required || !output.path->empty(), "--{} is missing", output.flag);
    if (output.path->empty()) return;
    check_name("--" + output.flag, *output.path);
    std::error_code error;
    const fs::path path(*output.path);
    require_input(path.has_filename() && !fs::is_directory(path, error), "--{}: {} is a folder, expected a file",
                  output.flag, *output.path);
    try {
        writing_path(*output.path);
    } catch (const InputError& problem) {
        throw InputError(fmt::format("--{}: {}", output.flag, problem.what()));
    }
    require_input(force || output.resumable || !fs::exists(path, error),
                  "--{}: {} exists already, give --force to overwrite it", output.flag, *output.path);
}

void check_differs(const ToolOutput& output, const ToolInput& input)
{
    std::error_code error;
    for (const std::string& path : input.list()) {
        require_input(!fs::equivalent(path, *output.path, error), "--{}: {} is also the input {}", output.flag,
                      *output.path, input.name());
    }
}

void prepare_output(const ToolOutput& output)
{
    const std::string path = writing_path(*output.path);
    const fs::path folder = fs::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) fs::create_directories(folder, error);
    require_input(!error, "--{}: cannot make folder {}: {}", output.flag, folder.string(), error.message());
    const std::string trial = temporary_name(path);
    const int descriptor = ::open(trial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    require_input(descriptor >= 0, "--{}: cannot write to {}: {}", output.flag, folder.empty() ? "." : folder.string(),
                  std::strerror(errno));
    ::close(descriptor);
    ::unlink(trial.c_str());
}

}  // namespace ndg
