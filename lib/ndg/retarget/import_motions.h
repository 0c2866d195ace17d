// SPDX-License-Identifier: Apache-2.0
// Motion files of any kind as poses on a body: what import-motion writes and animate uses at once.
#pragma once

#include "ndg/core/tool.h"
#include "ndg/retarget/retarget.h"
#include "ndg/retarget/retarget_units.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// Motions and the files that say how they fit the project's skeleton.
struct MotionFiles {
    std::vector<std::string> motions;    ///< find_motion_files lists what they may be
    std::vector<std::string> joint_map;  ///< for all clips; of several each clip takes the one that fits
    std::string joint_maps;  ///< folder; each clip that no joint_map fits takes the one that fits its joints
    std::string reference;   ///< motion of the same rig with a frame in which the performer stands straight
    std::string joint_limits;
    std::string rest_joints;  ///< body model that AMASS's poses belong to (SmplSkeleton); "" without

    /// --motion, --joint-map, --joint-maps, --reference, --rest-joints and --joint-limits; the tool keeps references.
    void add(Tool& tool, bool required);
    /// The project's own maps and limits where none are given (installed_path).
    void complete();
};

struct MotionImportOptions {
    RetargetOptions retarget;
    ConventionOptions conventions;
    /// Poses exactly `frame_rate` apart, by interpolation (resample_poses; keyframes are evaluated there). Otherwise
    /// those frames of the file are kept that lie nearest.
    bool interpolate = false;
    double source_rate = 0.0;  ///< Hz, of the files; 0: as they say
    /// Degrees; a clip disagrees with its source where a segment points elsewhere by more in the mean; feet by ten
    /// more.
    double max_segment_error = 15.0;
};
void describe(OptionList& list, MotionImportOptions& options);

struct ImportedMotions {
    PoseSet poses;
    std::vector<RetargetReport> reports;     ///< of the clips that were retargeted
    int num_own = 0;                         ///< motions of our own (keyframes)
    int num_copies = 0, num_unmapped = 0;    ///< left out: takes read before; clips of folders that no joint map fits
    std::string licences;                    ///< of our own motions
    std::vector<std::string> failures;       ///< files of folders that could not be read, one sentence each
    std::vector<std::string> disagreements;  ///< clips that disagree with their source, one sentence each

    /// Throws QualityError with all failures and disagreements where there are any.
    void check() const;
};

/// All clips, one after the other, for a body with these rest joints (J x 3); `tell` gets a line about each. A motion
/// that is there already (same_motion) is left out, whatever its name. Files of folders that cannot be read are listed
/// as failures, those that no joint map fits are counted. Throws InputError naming file and item: a named file that
/// cannot be read or that no joint map fits, no pose at all.
ImportedMotions import_motions(const MotionFiles& files, const MotionImportOptions& options,
                               const Eigen::Ref<const Points>& joint_positions,
                               const std::function<void(const std::string& line)>& tell);

}  // namespace ndg
