// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/motion_files.h"

#include "ndg/core/error.h"
#include "ndg/motion/keyframes.h"

#include <algorithm>
#include <cctype>
#include <cmath>
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

/// Files of a folder, sorted; throws InputError where it cannot be listed.
std::vector<fs::path> list_folder(const fs::path& folder, bool recursively)
{
    std::vector<fs::path> files;
    try {
        if (recursively) {
            for (const auto& entry : fs::recursive_directory_iterator(folder)) {
                if (entry.is_regular_file()) files.push_back(entry.path());
            }
        } else {
            for (const auto& entry : fs::directory_iterator(folder)) {
                if (entry.is_regular_file()) files.push_back(entry.path());
            }
        }
    } catch (const fs::filesystem_error& error) {
        throw InputError(fmt::format("{}: cannot be listed: {}", folder.string(), error.code().message()));
    }
    std::sort(files.begin(), files.end());
    return files;
}

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
    for (const fs::path& file : list_folder(folder, false)) {
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
        for (const fs::path& file : list_folder(path, true)) {
            if (!skeleton_name(file)) files.push_back(classify(file, true));
        }
    }
    return files;
}

MotionClip read_motion(const MotionFile& file)
{
    const std::string kind = extension(file.path);
    if (kind == ".amc") return read_asf_amc(file.skeleton_path, file.path);
    if (kind == ".npz") return read_amass(file.path);
    if (kind != ".bvh") return read_deepmimic(file.skeleton_path, file.path);
    return read_bvh(file.path);
}

std::string ClipNames::add(const MotionClip& clip, const std::string& path)
{
    const double seconds = clip.num_frames() / clip.frame_rate;
    std::string name = clip.name;
    for (const Known& other : known_) {
        if (other.stem != clip.name) continue;
        if (std::abs(other.seconds - seconds) <= 2.0 / clip.frame_rate) return "";
        name = fs::path(path).parent_path().filename().string() + "/" + clip.name;
    }
    for (const Known& other : known_) {
        require_input(other.name != name, "{}: a clip of the name {} has been read already, rename one", path, name);
    }
    known_.push_back({clip.name, name, seconds});
    return name;
}

}  // namespace ndg
