// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/video_file.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "ndg/scene/video_webp.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

extern char** environ;

namespace ndg {
namespace {

class PngWriter : public VideoWriter {
public:
    explicit PngWriter(std::vector<std::string> files) : files_(std::move(files)) {}
    void add(const Image& frame) override { write_png(files_.at(next_++), frame); }
    void finish() override {}

private:
    std::vector<std::string> files_;
    std::size_t next_ = 0;
};

/// Raw frames through a pipe. The program finds its format by the extension, so that the temporary name keeps it.
class FfmpegWriter : public VideoWriter {
public:
    FfmpegWriter(const std::string& path, double frame_rate, int quality)
        : path_(path), frame_rate_(frame_rate), quality_(quality)
    {
        const std::filesystem::path file = path;
        temporary_ = temporary_name((file.parent_path() / file.stem()).string()) + file.extension().string();
        // A program that ends early is told by its exit code, not by the end of ours.
        std::signal(SIGPIPE, SIG_IGN);
        run({"-version"}, true);
    }
    ~FfmpegWriter() override
    {
        if (child_ <= 0) return;
        close_pipe();
        wait_for_child();
        std::filesystem::remove(temporary_);
    }

    void add(const Image& frame) override
    {
        if (child_ <= 0) start(frame.width, frame.height);
        const char* bytes = reinterpret_cast<const char*>(frame.pixels.data());
        std::size_t left = frame.pixels.size() * sizeof(Pixel);
        while (left > 0) {
            const ssize_t written = ::write(pipe_, bytes, left);
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) return fail();
            bytes += written;
            left -= std::size_t(written);
        }
    }
    void finish() override
    {
        close_pipe();
        if (wait_for_child() != 0) fail();
        replace_file(temporary_, path_);
    }

private:
    void start(int width, int height)
    {
        std::vector<std::string> arguments = {"-loglevel",
                                              "error",
                                              "-y",
                                              "-f",
                                              "rawvideo",
                                              "-pixel_format",
                                              "rgb24",
                                              "-video_size",
                                              fmt::format("{}x{}", width, height),
                                              "-framerate",
                                              fmt::format("{}", frame_rate_),
                                              "-i",
                                              "-"};
        // What players understand; GIF has colours of its own. Both sides of such pictures are even.
        if (lower_extension(path_) != ".gif")
            for (const std::string& argument :
                 {std::string("-vf"), std::string("crop=trunc(iw/2)*2:trunc(ih/2)*2"), std::string("-pix_fmt"),
                  std::string("yuv420p"), std::string("-crf"), fmt::format("{}", 51 - quality_ * 41 / 100)})
                arguments.push_back(argument);
        arguments.push_back(temporary_);
        run(arguments, false);
    }
    /// Starts the program with a pipe to its input; `only_try`: waits for its end and shows nothing.
    void run(std::vector<std::string> arguments, bool only_try)
    {
        arguments.insert(arguments.begin(), "ffmpeg");
        std::vector<char*> pointers;
        for (std::string& argument : arguments) pointers.push_back(argument.data());
        pointers.push_back(nullptr);
        int ends[2];
        require(::pipe(ends) == 0, "{}: no pipe to ffmpeg ({})", path_, std::strerror(errno));
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
        posix_spawn_file_actions_addclose(&actions, ends[0]);
        posix_spawn_file_actions_addclose(&actions, ends[1]);
        if (only_try) posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        const int error = posix_spawnp(&child_, "ffmpeg", &actions, nullptr, pointers.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        ::close(ends[0]);
        pipe_ = ends[1];
        if (error != 0) {
            child_ = -1;
            close_pipe();
            throw InputError(
                fmt::format("{}: the program ffmpeg cannot be started ({}); install it, or write an animated "
                            ".webp or numbered pictures, frame_{{:04}}.png, which need no other program",
                            path_, std::strerror(error)));
        }
        if (!only_try) return;
        close_pipe();
        const int status = wait_for_child();
        require_input(status == 0, "{}: ffmpeg does not run (exit code {})", path_, status);
    }
    void close_pipe()
    {
        if (pipe_ >= 0) ::close(pipe_);
        pipe_ = -1;
    }
    int wait_for_child()
    {
        int status = 0;
        while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) continue;
        child_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    [[noreturn]] void fail()
    {
        close_pipe();
        const int status = child_ > 0 ? wait_for_child() : 1;
        std::filesystem::remove(temporary_);
        throw Error(
            fmt::format("{}: ffmpeg could not write it (exit code {}); its message stands above", path_, status));
    }

    std::string path_, temporary_;
    double frame_rate_;
    int quality_;
    pid_t child_ = -1;
    int pipe_ = -1;
};

}  // namespace

std::vector<std::string> video_files(const std::string& path, int num_frames)
{
    if (lower_extension(path) != ".png" || (num_frames == 1 && path.find_first_of("{}") == std::string::npos))
        return {path};
    require_input(path.find_first_of("{}") != std::string::npos,
                  "{}: {} frames need the place of their number in the name, like {{:04}}", path, num_frames);
    return numbered_names(path, num_frames);
}

std::unique_ptr<VideoWriter> video_writer(const std::string& path, int num_frames, double frame_rate, int quality)
{
    const std::string extension = lower_extension(path);
    if (extension == ".png") return std::make_unique<PngWriter>(video_files(path, num_frames));
    if (extension == ".webp") return webp_writer(path, frame_rate, quality);
    for (const char* known : {".mp4", ".mkv", ".mov", ".webm", ".gif"})
        if (extension == known) return std::make_unique<FfmpegWriter>(path, frame_rate, quality);
    throw InputError(
        fmt::format("{}: videos cannot be written as '{}'; known are .webp, .png with {{:04}} in the name, "
                    "and by ffmpeg .mp4, .mkv, .mov, .webm, .gif",
                    path, extension));
}

}  // namespace ndg
