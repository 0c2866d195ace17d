// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/io/motion.h"

#include <set>
#include <string>
#include <vector>

namespace ndg {

struct MotionFile {
    std::string path;           ///< .bvh, .amc, DeepMimic's .txt or .json, AMASS's .npz, or keyframes
    std::string skeleton_path;  ///< .asf beside an .amc, *_character.json beside a DeepMimic clip; "" otherwise
    bool from_folder = false;   ///< found in a folder rather than named
    bool keyframes = false;     ///< a motion of our own (keyframes.h), not one to retarget
    std::string skip_reason;    ///< not empty: is no motion, and what it is
    std::string error;          ///< not empty: cannot be read, a sentence that names the file
};

/// Motion files among `paths`; folders are searched recursively, in the order of their names, links are followed (once:
/// what a link leads to and is read already is listed with a skip_reason, as are links to nothing), names that begin
/// with a dot are passed over. The skeleton of an AMC is the only ASF beside it, or the one whose name is the longest
/// beginning of the AMC's; that of a DeepMimic clip (JSON with "Frames") is found likewise among the files
/// NAME_character.json. Files of folders that are no motions are listed with a skip_reason, clips without a skeleton
/// and folders that cannot be listed with an error; for named files both are InputErrors.
std::vector<MotionFile> find_motion_files(const std::vector<std::string>& paths);

/// Not for keyframes. `amass_model`: whose joints AMASS's poses turn (read_amass).
MotionClip read_motion(const MotionFile& file, const SmplSkeleton* amass_model = nullptr);

/// One name for each clip.
class ClipNames {
public:
    /// The name of the file or, where another clip has it already, with as many of the folders above it as tell it from
    /// all others ("s2/walk"); in the end with the extension, or a number.
    std::string add(const std::string& path);

private:
    std::set<std::string> known_;
};

}  // namespace ndg
