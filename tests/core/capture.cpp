// SPDX-License-Identifier: Apache-2.0
#include "capture.h"

#include "ndg/core/file.h"
#include "support/support.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

namespace ndg::test {
namespace {

/// Sends a stream to a file until the end of the scope.
class Redirection {
public:
    Redirection(std::FILE* stream, const std::string& path) : stream_(stream), descriptor_(fileno(stream))
    {
        std::fflush(stream_);
        saved_ = dup(descriptor_);
        const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(file, descriptor_);
        close(file);
    }
    ~Redirection()
    {
        std::fflush(stream_);
        dup2(saved_, descriptor_);
        close(saved_);
    }

private:
    std::FILE* stream_;
    int descriptor_, saved_ = -1;
};

}  // namespace

ToolRun run_tool(Tool& tool, const std::vector<std::string>& arguments, const std::function<void()>& body)
{
    const TemporaryFolder folder;
    std::vector<std::string> words = {"program"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    ToolRun result;
    {
        const Redirection out(stdout, folder.file("out")), err(stderr, folder.file("err"));
        result.exit_code = tool.run(static_cast<int>(argv.size()), argv.data(), body);
    }
    result.out = read_file(folder.file("out"));
    result.err = read_file(folder.file("err"));
    return result;
}

}  // namespace ndg::test
