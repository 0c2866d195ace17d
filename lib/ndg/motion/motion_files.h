// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/io/motion.h"

#include <string>
#include <vector>

namespace ndg {

struct MotionFile {
    std::string path;           ///< .bvh, .amc, DeepMimic's .txt or .json, AMASS's .npz, or keyframes
    std::string skeleton_path;  ///< .asf beside an .amc, *_character.json beside a DeepMimic clip; "" otherwise
    bool from_folder = false;   ///< found in a folder rather than named
    bool keyframes = false;     ///< a motion of our own (keyframes.h), not one to retarget
    std::string skip_reason;    ///< not empty: cannot be used, and why
};

/// Motion files among `paths`; folders are searched recursively, in the order of their names. The skeleton of an AMC is
/// the only ASF beside it, or the one whose name is the longest beginning of the AMC's; that of a DeepMimic clip (JSON
/// with "Frames") is found likewise among the files NAME_character.json. Files of folders that are no motions are
/// listed with a skip_reason; a named file that is no motion, and a clip without a skeleton, are InputErrors.
std::vector<MotionFile> find_motion_files(const std::vector<std::string>& paths);

/// Not for keyframes.
MotionClip read_motion(const MotionFile& file);

/// Tells apart takes and copies of takes. The same take stored twice (CMU takes exist as AMC and as BVH) would put the
/// same poses on both sides of a split.
class ClipNames {
public:
    /// Returns "" if a clip of this name and, within two frames, this duration was added before; otherwise the name to
    /// use: the clip's own or, where another clip has it already, "folder/name".
    std::string add(const MotionClip& clip, const std::string& path);

private:
    struct Known {
        std::string stem, name;
        double seconds;
    };
    std::vector<Known> known_;
};

}  // namespace ndg
