// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/motion_files.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

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

/// The ASF beside an AMC: the only one, or the one whose name is the longest beginning of the AMC's (02.asf of
/// 02_01.amc).
std::string find_skeleton(const fs::path& amc)
{
    const fs::path folder = amc.parent_path().empty() ? fs::path(".") : amc.parent_path();
    std::vector<fs::path> skeletons, named;
    for (const fs::path& file : list_folder(folder, false)) {
        if (extension(file) != ".asf") continue;
        skeletons.push_back(file);
        const std::string stem = file.stem().string();
        if (amc.stem().string().compare(0, stem.size(), stem) == 0) named.push_back(file);
    }
    require_input(!skeletons.empty(), "{}: there is no .asf skeleton beside it", amc.string());
    if (skeletons.size() == 1) return skeletons.front().string();
    require_input(!named.empty(), "{}: its name begins like none of the {} .asf skeletons beside it", amc.string(),
                  skeletons.size());
    const auto longer = [](const fs::path& a, const fs::path& b) {
        return a.stem().string().size() < b.stem().string().size();
    };
    return std::max_element(named.begin(), named.end(), longer)->string();
}

MotionFile classify(const fs::path& path, bool from_folder)
{
    MotionFile file;
    file.path = path.string();
    file.from_folder = from_folder;
    const std::string kind = extension(path);
    if (kind == ".amc") {
        file.skeleton_path = find_skeleton(path);
    } else if (kind != ".bvh") {
        file.skip_reason = "not a .bvh or .amc motion";
        require_input(from_folder, "{}: is {}", file.path, file.skip_reason);
    }
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
            if (extension(file) != ".asf") files.push_back(classify(file, true));
        }
    }
    return files;
}

MotionClip read_motion(const MotionFile& file)
{
    if (!file.skeleton_path.empty()) return read_asf_amc(file.skeleton_path, file.path);
    return read_bvh(file.path);
}

std::vector<JointMap> read_joint_maps(const std::string& folder)
{
    std::vector<JointMap> maps;
    require_input(fs::is_directory(folder), "{}: is not a folder of joint maps", folder);
    for (const fs::path& file : list_folder(folder, false)) {
        if (extension(file) == ".json") maps.push_back(read_joint_map(file.string()));
    }
    require_input(!maps.empty(), "{}: holds no joint map (*.json)", folder);
    return maps;
}

const JointMap* find_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip)
{
    const JointMap* found = nullptr;
    for (const JointMap& map : maps) {
        if (!missing_source_joint(map, clip).empty()) continue;
        require_input(found == nullptr, "clip {}: the joint maps {} and {} both fit, name one", clip.name,
                      found ? found->path : "", map.path);
        found = &map;
    }
    return found;
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
