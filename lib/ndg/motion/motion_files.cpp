// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/motion_files.h"

#include "ndg/core/error.h"
#include "ndg/motion/keyframes.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <optional>

namespace ndg {

namespace {

namespace fs = std::filesystem;

std::string extension(const fs::path& path)
{
    std::string text = path.extension().string();
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

bool is_hidden(const fs::path& path)
{
    const std::string name = path.filename().string();
    return !name.empty() && name[0] == '.';
}

/// Files of a folder, sorted; throws InputError where it cannot be listed.
std::vector<fs::path> list_folder(const fs::path& folder)
{
    std::vector<fs::path> files;
    try {
        for (const auto& entry : fs::directory_iterator(folder)) {
            if (!is_hidden(entry.path()) && entry.is_regular_file()) files.push_back(entry.path());
        }
    } catch (const fs::filesystem_error& error) {
        throw InputError(fmt::format("{}: cannot be listed: {}", folder.string(), error.code().message()));
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// All files below a folder, links followed: first what lies there itself, then what links lead to.
class FolderWalk {
public:
    explicit FolderWalk(const fs::path& folder)
    {
        walk(folder);
        while (!links_.empty()) {
            const std::vector<fs::path> links = std::move(links_);
            links_.clear();
            for (const fs::path& link : links) follow(link);
        }
        std::sort(files.begin(), files.end());
    }

    std::vector<fs::path> files;
    std::vector<MotionFile> others;  ///< links that lead nowhere new, folders that cannot be listed

private:
    void walk(const fs::path& folder)
    {
        std::error_code error;
        if (!known_.insert(fs::canonical(folder, error).string()).second) return;
        std::vector<fs::path> entries;
        fs::directory_iterator next(folder, error);
        for (; !error && next != fs::directory_iterator(); next.increment(error)) entries.push_back(next->path());
        if (error) {
            MotionFile file;
            file.path = folder.string();
            file.from_folder = true;
            file.error = fmt::format("{}: cannot be listed: {}", folder.string(), error.message());
            others.push_back(file);
            return;
        }
        std::sort(entries.begin(), entries.end());
        for (const fs::path& entry : entries) {
            if (is_hidden(entry)) continue;
            if (fs::is_symlink(entry, error)) {
                links_.push_back(entry);
            } else if (fs::is_directory(entry, error)) {
                walk(entry);
            } else if (fs::is_regular_file(entry, error)) {
                known_.insert(fs::canonical(entry, error).string());
                files.push_back(entry);
            }
        }
    }

    void follow(const fs::path& link)
    {
        std::error_code error;
        const std::string target = fs::canonical(link, error).string();
        if (error || !fs::exists(target, error)) return skip(link, "a link that leads nowhere");
        if (known_.count(target) > 0) return skip(link, "a link to what is read already");
        if (fs::is_directory(target, error)) return walk(link);
        if (!fs::is_regular_file(target, error)) return;
        known_.insert(target);
        files.push_back(link);
    }

    void skip(const fs::path& path, const std::string& reason)
    {
        MotionFile file;
        file.path = path.string();
        file.from_folder = true;
        file.skip_reason = reason;
        others.push_back(file);
    }

    std::set<std::string> known_;
    std::vector<fs::path> links_;
};

const std::string character_ending = "_character";

/// The beginning that names of a skeleton's motions share: "02" of 02.asf, "humanoid3d" of humanoid3d_character.json.
/// Nothing where the file is no skeleton.
std::optional<std::string> skeleton_name(const fs::path& path)
{
    const std::string stem = path.stem().string();
    if (extension(path) == ".asf") return stem;
    const bool longer = stem.size() > character_ending.size();
    if (extension(path) != ".json" || !longer) return std::nullopt;
    const std::size_t length = stem.size() - character_ending.size();
    if (stem.substr(length) != character_ending) return std::nullopt;
    return stem.substr(0, length);
}

/// The skeleton of the extension `kind` beside a motion: the only one, or the one whose name is the longest beginning
/// of the motion's (02.asf of 02_01.amc). `form` says in messages what it looks like.
std::string find_skeleton(const fs::path& motion, const std::string& kind, const std::string& form)
{
    const fs::path folder = motion.parent_path().empty() ? fs::path(".") : motion.parent_path();
    std::vector<fs::path> skeletons, named;
    for (const fs::path& file : list_folder(folder)) {
        const std::optional<std::string> name = skeleton_name(file);
        if (!name || extension(file) != kind) continue;
        skeletons.push_back(file);
        if (motion.stem().string().compare(0, name->size(), *name) == 0) named.push_back(file);
    }
    require_input(!skeletons.empty(), "{}: there is no {} skeleton beside it", motion.string(), form);
    if (skeletons.size() == 1) return skeletons.front().string();
    require_input(!named.empty(), "{}: its name begins like none of the {} {} skeletons beside it", motion.string(),
                  skeletons.size(), form);
    const auto shorter = [](const fs::path& a, const fs::path& b) {
        return skeleton_name(a)->size() < skeleton_name(b)->size();
    };
    return std::max_element(named.begin(), named.end(), shorter)->string();
}

/// Whether a text file begins as a DeepMimic clip does: a JSON object with frames, which follow a few short settings.
bool looks_like_deepmimic(const fs::path& path)
{
    std::ifstream file(path, std::ios::binary);
    std::string head(4096, '\0');
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(file.gcount());
    const std::size_t first = head.find_first_not_of(" \t\r\n");
    return first != std::string::npos && head[first] == '{' && head.find("\"Frames\"") != std::string::npos;
}

MotionFile classify(const fs::path& path, bool from_folder)
{
    MotionFile file;
    file.path = path.string();
    file.from_folder = from_folder;
    const std::string kind = extension(path);
    if (kind == ".bvh") return file;
    if (kind == ".amc") {
        file.skeleton_path = find_skeleton(path, ".asf", ".asf");
    } else if (kind == ".npz") {
        if (!is_amass(file.path)) file.skip_reason = "an .npz without AMASS poses";
    } else if (is_keyframe_motion(file.path)) {
        file.keyframes = true;
    } else if ((kind == ".txt" || kind == ".json") && looks_like_deepmimic(path)) {
        file.skeleton_path = find_skeleton(path, ".json", "*" + character_ending + ".json");
    } else {
        file.skip_reason = "not a BVH, AMC, DeepMimic, AMASS or keyframe motion";
    }
    require_input(file.skip_reason.empty() || from_folder, "{}: is {}", file.path, file.skip_reason);
    return file;
}

MotionFile classify_found(const fs::path& path)
{
    try {
        return classify(path, true);
    } catch (const InputError& error) {
        MotionFile file;
        file.path = path.string();
        file.from_folder = true;
        file.error = error.what();
        return file;
    }
}

}  // namespace

std::vector<MotionFile> find_motion_files(const std::vector<std::string>& paths)
{
    std::vector<MotionFile> files;
    for (const std::string& path : paths) {
        require_input(fs::exists(path), "{}: does not exist", path);
        if (!fs::is_directory(path)) {
            files.push_back(classify(path, false));
            continue;
        }
        const FolderWalk walk(path);
        for (const fs::path& file : walk.files) {
            if (!skeleton_name(file)) files.push_back(classify_found(file));
        }
        files.insert(files.end(), walk.others.begin(), walk.others.end());
    }
    return files;
}

MotionClip read_motion(const MotionFile& file, const SmplSkeleton* amass_model)
{
    const std::string kind = extension(file.path);
    if (kind == ".amc") return read_asf_amc(file.skeleton_path, file.path);
    if (kind == ".npz") return read_amass(file.path, amass_model);
    if (kind != ".bvh") return read_deepmimic(file.skeleton_path, file.path);
    return read_bvh(file.path);
}

std::string ClipNames::add(const std::string& path)
{
    const fs::path file = fs::absolute(path).lexically_normal();
    std::string name = file.stem().string();
    fs::path above = file.parent_path();
    while (known_.count(name) > 0 && above.has_relative_path()) {
        name = above.filename().string() + "/" + name;
        above = above.parent_path();
    }
    if (known_.count(name) > 0) name += file.extension().string();
    const std::string with_extension = name;
    for (int k = 2; known_.count(name) > 0; ++k) name = fmt::format("{} {}", with_extension, k);
    known_.insert(name);
    return name;
}

}  // namespace ndg
