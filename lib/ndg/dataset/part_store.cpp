// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/part_store.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <utility>
#include <vector>

namespace ndg {

namespace {

namespace fs = std::filesystem;

const std::string done_ending = ".h5", failed_ending = ".failed.h5";

std::string folder_of(const std::string& output)
{
    return output + ".parts";
}

std::string lock_path(const std::string& folder)
{
    return folder + "/process";
}

std::string part_path(const std::string& folder, const BatchItem& item, const std::string& ending)
{
    return folder + "/" + item.file + ending;
}

bool ends_with(const std::string& text, const std::string& ending)
{
    return text.size() > ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

double wall_seconds(const timespec& time)
{
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Who is, or was last, at a folder of parts, since when (seconds of the system clock), and for which key.
struct Holder {
    std::string process = "another process", key;
    double start = 0;
};

Holder read_holder(const std::string& folder)
{
    Holder holder;
    std::FILE* file = std::fopen(lock_path(folder).c_str(), "r");
    if (file == nullptr) return holder;
    long pid = 0;
    char host[256] = "", key[256] = "";
    if (std::fscanf(file, "%ld %255s %lf %255s", &pid, host, &holder.start, key) == 4) {
        holder.process = fmt::format("process {} on {}", pid, host);
        holder.key = key;
    }
    std::fclose(file);
    return holder;
}

struct flock whole_file()
{
    struct flock range = {};
    range.l_type = F_WRLCK;
    range.l_whence = SEEK_SET;
    return range;
}

/// Opens the lock file and takes the lock; the kernel gives it back when the process ends, however it ends.
int take_lock(const std::string& folder, const std::string& kind)
{
    const int file = ::open(lock_path(folder).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    require_input(file >= 0, "{}: the folder for finished {} cannot be written ({})", folder, kind,
                  std::strerror(errno));
    struct flock range = whole_file();
    if (::fcntl(file, F_OFD_SETLK, &range) == 0) return file;
    if (errno == EAGAIN || errno == EACCES) {
        ::close(file);
        throw InputError(fmt::format("{}: {} is at these {} already", folder, read_holder(folder).process, kind));
    }
    log_warning("{}: this file system has no locks ({}); start no two processes at the same output", folder,
                std::strerror(errno));
    return file;
}

bool is_locked(const std::string& folder)
{
    const int file = ::open(lock_path(folder).c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return false;
    struct flock range = whole_file();
    const bool locked = ::fcntl(file, F_OFD_GETLK, &range) == 0 && range.l_type != F_UNLCK;
    ::close(file);
    return locked;
}

void write_holder(int file, const std::string& folder, const std::string& key)
{
    char host[256] = "unknown";
    ::gethostname(host, sizeof host - 1);
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    const std::string text = fmt::format("{} {} {}.{:09} {}\n", ::getpid(), host, now.tv_sec, now.tv_nsec, key);
    const bool written =
        ::ftruncate(file, 0) == 0 && ::pwrite(file, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
    require(written, "{}: the folder of parts cannot be written ({})", folder, std::strerror(errno));
}

/// Removes the files whose name `unwanted` accepts.
template <typename Unwanted>
int remove_files(const std::string& folder, const Unwanted& unwanted)
{
    int count = 0;
    std::error_code error;
    std::vector<fs::path> paths;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (unwanted(entry.path().filename().string())) paths.push_back(entry.path());
    }
    for (const fs::path& path : paths) count += fs::remove(path, error);
    return count;
}

/// Moves the files whose name `wanted` accepts to a folder of their own beside theirs; how many, and its name.
template <typename Wanted>
std::pair<int, std::string> set_aside(const std::string& folder, const Wanted& wanted)
{
    std::vector<fs::path> paths;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        if (wanted(entry.path().filename().string())) paths.push_back(entry.path());
    }
    if (paths.empty()) return {0, ""};
    int number = 1;
    while (fs::exists(fmt::format("{}.{}", folder, number))) ++number;
    const std::string other = fmt::format("{}.{}", folder, number);
    std::error_code error;
    fs::create_directory(other, error);
    for (const fs::path& path : paths) {
        if (!error) fs::rename(path, fs::path(other) / path.filename(), error);
    }
    require(!error, "{}: its files could not be set aside in {}: {}", folder, other, error.message());
    return {static_cast<int>(paths.size()), other};
}

/// NAME.<pid>.tmp, where a killed process left it.
bool is_temporary(const std::string& name, const std::string& whole_name)
{
    if (name.rfind(whole_name + ".", 0) != 0 || !ends_with(name, ".tmp")) return false;
    const std::size_t begin = whole_name.size() + 1, end = name.size() - 4;
    return end > begin && name.find_first_not_of("0123456789", begin) == end;
}

}  // namespace

std::optional<PartsStatus> parts_status(const std::string& output)
{
    const std::string folder = folder_of(output);
    if (!fs::is_directory(folder)) return std::nullopt;
    PartsStatus status;
    const Holder holder = read_holder(folder);
    status.process = holder.process;
    int since_start = 0;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        const bool failed = ends_with(name, failed_ending);
        if (!failed && !ends_with(name, done_ending)) continue;
        ++(failed ? status.failed : status.done);
        struct stat info = {};
        if (::stat(entry.path().c_str(), &info) != 0) continue;  // renamed or removed since
        since_start += wall_seconds(info.st_mtim) >= holder.start;
    }
    status.running = is_locked(folder);
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    const double seconds = wall_seconds(now) - holder.start;
    if (status.running && seconds > 0) status.rate_hertz = since_start / seconds;
    return status;
}

PartStore::PartStore(const std::string& output, const PartKind& kind, const std::string& key, bool set_others_aside)
    : path_(folder_of(output)), key_(sha256(key)), kind_(kind)
{
    std::error_code error;
    fs::create_directories(path_, error);
    require_input(!error && fs::is_directory(path_), "{}: the folder for finished {} could not be made ({})", path_,
                  kind_.items, error ? error.message() : "a file of that name exists");
    lock_ = take_lock(path_, kind_.items);
    try {
        const std::string previous_key = read_holder(path_).key;
        if (!previous_key.empty() && previous_key != key_) {
            const auto is_part = [](const std::string& name) { return ends_with(name, done_ending); };
            const std::optional<PartsStatus> found = parts_status(output);
            require_input(
                set_others_aside || found->done + found->failed == 0,
                "{}: holds {} {} made by another version of the method, from other inputs or with other options; "
                "--force sets them aside",
                path_, found->done + found->failed, kind_.items);
            const auto [count, folder] = set_aside(path_, is_part);
            if (count > 0) {
                log_warning(
                    "{} {} of another version of the method, other inputs or options were set aside in {}; remove it "
                    "when nobody needs them",
                    count, kind_.items, folder);
            }
        }
        write_holder(lock_, path_, key_);
        // What killed processes left: nobody else writes here while the lock is held.
        remove_files(path_, [](const std::string& name) { return ends_with(name, ".tmp"); });
        const fs::path file(output), parent = file.parent_path().empty() ? "." : file.parent_path();
        remove_files(parent.string(),
                     [&](const std::string& name) { return is_temporary(name, file.filename().string()); });
    } catch (...) {
        ::close(lock_);
        throw;
    }
}

PartStore::~PartStore()
{
    ::close(lock_);
}

void PartStore::write(const BatchItem& item, const PartWriter& payload) const
{
    write_part(item, "", payload);
}

void PartStore::write_failure(const BatchItem& item, const std::string& reason) const
{
    write_part(item, reason, [](H5Writer&) {});
}

void PartStore::write_part(const BatchItem& item, const std::string& failure, const PartWriter& payload) const
{
    const std::lock_guard<std::mutex> lock(mutex_);
    H5Writer file(part_path(path_, item, failure.empty() ? done_ending : failed_ending), kind_.format, kind_.version,
                  {});
    file.attribute("key", key_);
    file.attribute("item", item.identity);
    file.attribute("failure", failure);
    payload(file);
    file.commit();
}

std::optional<std::string> PartStore::find(const BatchItem& item, const PartReader& payload) const
{
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const std::string& ending : {done_ending, failed_ending}) {
        const std::string path = part_path(path_, item, ending);
        if (!fs::exists(path)) continue;
        try {
            const H5Reader file(path, kind_.format, kind_.version);
            if (file.attribute("key") == key_ && file.attribute("item") == item.identity) {
                std::string failure = file.attribute("failure");
                if (failure.empty()) payload(file);
                return failure;
            }
        } catch (const InputError& error) {
            log_warning("{} is made again: {}", item.label, error.what());
        }
        // Of other inputs or damaged: as good as none, and not to be counted as done.
        std::error_code error;
        fs::remove(path, error);
    }
    return std::nullopt;
}

std::string PartStore::read(const BatchItem& item, const PartReader& payload) const
{
    std::optional<std::string> failure = find(item, payload);
    require(failure.has_value(), "{}: {} cannot be read back", path_, item.label);
    return std::move(*failure);
}

void PartStore::remove() const
{
    std::error_code error;
    fs::remove_all(path_, error);
    if (error)
        log_warning("{}: the folder of finished {} could not be removed ({})", path_, kind_.items, error.message());
}

}  // namespace ndg
