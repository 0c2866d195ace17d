// SPDX-License-Identifier: Apache-2.0
// Which joints of a motion-capture skeleton drive which joints of ours (configs/joint-maps/*.json).
#pragma once

#include "ndg/io/motion.h"

#include <string>
#include <vector>

namespace ndg {

/// How one of our joints follows the source. Joints of ours without an entry keep identity local rotations.
struct JointMapEntry {
    std::string joint;       ///< name on the standard skeleton
    std::string source;      ///< source joint whose world rotation it takes
    std::string blend_with;  ///< if set: the rotation lies `fraction` of the way from `source` to this joint
    double fraction = 0.0;
    /// Blend only the part of the relative rotation about the aligned bone (forearm pronation).
    bool twist_only = false;

    /// If set, our bone from this joint to the joint `toward` is aligned with the source's bone from `bone_from` to
    /// `bone_to` at the zero pose ("" stands for the tip of `bone_from`). Otherwise the parent's alignment holds.
    std::string toward, bone_from, bone_to;
    /// Align as a foot: the vertical of our rest pose with the source's sole normal, and the two bones' headings in the
    /// plane of the sole. The sole normal points from `up_from` to `up_to`, or along +y where these are empty.
    bool sole = false;
    std::string up_from, up_to;

    /// Radians; a frame in which the local rotation of this joint is further from rest is a tracking error (a foot
    /// turned backwards), whatever its speed.
    double limit = 2.0 * 3.141592653589793;
};

struct JointMap {
    std::string path;           ///< file it was read from
    int skip_first_frames = 0;  ///< artificial frames at the start of every clip (BVH of cgspeed: one T pose)
    /// Joints that tell a skeleton for another map (a later version of the same rig): clips with one of them do not
    /// fit.
    std::vector<std::string> without;
    std::vector<JointMapEntry> entries;

    /// Entry of a joint of ours, or nullptr.
    const JointMapEntry* find(const std::string& joint) const;
};

/// Throws InputError naming file, item and value: unknown key, joint that is not ours, missing pelvis or leg.
JointMap read_joint_map(const std::string& path);
/// All *.json of a folder, in the order of their names. Throws InputError where there is none.
std::vector<JointMap> read_joint_maps(const std::string& folder);

/// The map as a file that read_joint_map reads, one line a joint.
std::string joint_map_json(const JointMap& map, const std::string& description);

/// Name of a source joint the map needs and the clip lacks, "no JOINT" for one it must not have; "" where the map fits.
std::string missing_source_joint(const JointMap& map, const MotionClip& clip);

/// The map whose source joints the clip all has; nullptr where none fits. Throws InputError where several fit.
const JointMap* find_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip);

}  // namespace ndg
