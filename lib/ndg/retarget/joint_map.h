// SPDX-License-Identifier: Apache-2.0
// Which joints of a motion-capture skeleton drive which joints of ours (configs/joint-maps/*.json).
#pragma once

#include "ndg/io/motion.h"

#include <optional>
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

/// A map in a clip's own names of joints.
struct JointMapFit {
    JointMap map;  ///< what the clip need not have and lacks is left out: toes, fingers, jaw, eyes and bones to them
    std::vector<std::string> missing;  ///< joints the clip lacks ("no JOINT": must not have); empty: the map fits
    int num_joints = 0;                ///< joints of the clip that the map names
    int num_literal = 0;               ///< of them those of the very same name
};
/// Names are the same where they are so to the letter, else where their keys are (joint_name_keys): prefixes and
/// namespaces of a rig do not matter.
JointMapFit fit_joint_map(const JointMap& map, const MotionClip& clip);

/// Of the maps that fit the one that names most joints of the clip, of these the one that names most to the letter, in
/// the clip's names; none where none fits. Throws InputError where two are equal in both.
std::optional<JointMap> find_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip);

/// Which map comes nearest and what lacks, for messages: `FILE lacks "A", "B" and 3 more`.
std::string nearest_joint_map(const std::vector<JointMap>& maps, const MotionClip& clip);

}  // namespace ndg
