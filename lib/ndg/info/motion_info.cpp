// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/installed_files.h"
#include "ndg/info/describers.h"
#include "ndg/motion/keyframes.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/joint_map.h"
#include "ndg/retarget/retarget_units.h"

#include <algorithm>
#include <filesystem>
#include <optional>

namespace ndg {
namespace {

namespace fs = std::filesystem;

/// Which of the project's joint maps fits, and the axes and unit that it makes known.
void add_joint_map(MotionClip clip, FileReport& report)
{
    const std::string folder = installed_path("joint-maps");
    if (folder.empty()) return;
    const std::vector<JointMap> maps = read_joint_maps(folder);
    const std::optional<JointMap> map = find_joint_map(maps, clip);
    if (!map)
        return report.add("joint map", "none fits ({}); propose-joint-map makes one", nearest_joint_map(maps, clip));
    report.add("joint map", "{}: drives {} of our joints", fs::path(map->path).filename().string(),
               map->entries.size());
    const ClipConventions found = apply_conventions(clip, *map, ConventionOptions());
    report.add("axes", "up {}, front {} ({}); reference: {}", found.up, found.front, found.axes_from, found.reference);
    report.add("unit", "{:.4g} m ({}), the performer about {:.2f} m tall", found.metres_per_unit, found.unit_from,
               found.performer_stature);
}

void add_clip(const MotionClip& clip, FileReport& report)
{
    report.add("frames", "{} at {:.4g} Hz{}, {:.2f} s", clip.num_frames(), clip.frame_rate,
               clip.frame_rate_assumed ? " (assumed)" : "", clip.num_frames() / clip.frame_rate);
    report.add("joints", "{}: {}", clip.num_joints(), fmt::join(clip.joint_names, " "));
    const Eigen::RowVector3d way = clip.root_positions.colwise().maxCoeff() - clip.root_positions.colwise().minCoeff();
    report.add("root", "moves within {:.4g} x {:.4g} x {:.4g} in the file's unit and axes", way[0], way[1], way[2]);
    add_joint_map(clip, report);
}

}  // namespace

void describe_motion(const FileQuestion& file, FileReport& report)
{
    const MotionFile motion = find_motion_files({file.path}).front();
    if (motion.keyframes) {
        const KeyframeMotion keyframes = read_keyframe_motion(file.path);
        report.add("what", "a motion of our own, by keyframes of clinical joint angles (docs/motions.md)");
        if (!keyframes.description.empty()) report.add("description", keyframes.description);
        report.add("frames", "{} at {:.4g} Hz, {:.2f} s{}", keyframes.num_frames(), keyframes.frame_rate,
                   keyframes.duration,
                   keyframes.period > 0 ? fmt::format(", a cycle of {:.2f} s repeated", keyframes.period) : "");
        report.add("angles", "{} move", keyframes.tracks.size());
        report.add("licences", keyframes.licence);
        return;
    }
    report.add("what", "a motion on a skeleton of its own{}{}", motion.skeleton_path.empty() ? "" : ", that of ",
               motion.skeleton_path);
    add_clip(read_motion(motion), report);
}

void describe_skeleton(const FileQuestion& file, FileReport& report)
{
    const fs::path folder = fs::path(file.path).parent_path();
    report.add("what", "a skeleton of motions in files beside it");
    std::vector<MotionFile> motions;
    for (const MotionFile& motion : find_motion_files({folder.empty() ? "." : folder.string()}))
        if (fs::path(motion.skeleton_path).filename() == fs::path(file.path).filename()) motions.push_back(motion);
    report.add("motions", "{}", motions.size());
    if (motions.empty()) return;
    const MotionClip clip = read_motion(motions.front());
    report.add("joints", "{}: {}", clip.num_joints(), fmt::join(clip.joint_names, " "));
    add_joint_map(clip, report);
}

}  // namespace ndg
