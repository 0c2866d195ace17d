// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/import_motions.h"

#include "ndg/core/error.h"
#include "ndg/core/installed_files.h"
#include "ndg/core/log.h"
#include "ndg/motion/keyframes.h"
#include "ndg/motion/motion_files.h"
#include "ndg/motion/resample_poses.h"

#include <optional>

namespace ndg {

namespace {

std::string conventions_line(const RetargetReport& report)
{
    return fmt::format("{}: unit {:.4g} m ({}), performer {:.2f} m tall; up {}, front {} ({}); {:.4g} Hz{}",
                       report.clip_name, report.metres_per_unit, report.unit_from, report.performer_stature,
                       report.up_axis, report.front_axis, report.axes_from, report.frame_rate,
                       report.frame_rate_assumed ? " (assumed)" : "");
}

class MotionImport {
public:
    MotionImport(const MotionFiles& files, const MotionImportOptions& options,
                 const Eigen::Ref<const Points>& joint_positions, const std::function<void(const std::string&)>& tell)
        : options_(options), joint_positions_(joint_positions), tell_(tell)
    {
        require_input(files.joint_map.empty() || files.joint_maps.empty(),
                      "give one of --joint-map and --joint-maps, not both");
        require_input(!options.retarget.clamp_limits || !files.joint_limits.empty(),
                      "--clamp-joint-limits needs --joint-limits");
        if (!files.joint_map.empty()) maps_ = {read_joint_map(files.joint_map)};
        if (!files.joint_maps.empty()) maps_ = read_joint_maps(files.joint_maps);
        if (!files.joint_limits.empty()) limits_.emplace(read_joint_limits(files.joint_limits), joint_positions_);
        options_.retarget.limits = limits_ ? &*limits_ : nullptr;
        if (options_.interpolate) options_.retarget.frame_rate = 0.0;
        for (const MotionFile& file : find_motion_files(files.motions)) add(file);
        require_input(result_.poses.size() > 0, "{}: gave no pose", files.motions.front());
    }

    ImportedMotions take() { return std::move(result_); }

private:
    void add(const MotionFile& file)
    {
        if (!file.skip_reason.empty()) {
            tell_(fmt::format("skipped {}: {}", file.path, file.skip_reason));
        } else if (file.keyframes) {
            add_keyframes(file);
        } else {
            add_clip(file);
        }
    }

    /// Motions of our own need no retargeting; their angles are those of any body.
    void add_keyframes(const MotionFile& file)
    {
        KeyframeMotion motion = read_keyframe_motion(file.path);
        if (options_.interpolate && frame_rate_ > 0.0) motion.frame_rate = frame_rate_;
        MotionClip clip;
        clip.name = motion.name;
        clip.frame_rate = motion.frame_rate;
        clip.world_from_joint.resize(motion.num_frames());
        const std::string name = new_name(clip, file);
        if (name.empty()) return;
        PoseSet poses = keyframe_poses(motion, joint_positions_, options_.retarget.frame_rate);
        poses.clip_names.front() = name;
        std::string& licences = result_.licences;
        if (licences.find(motion.licence) == std::string::npos)
            licences += (licences.empty() ? "" : "; ") + motion.licence;
        tell_(fmt::format("{}: keyframes, {} poses", name, poses.size()));
        append_poses(result_.poses, poses);
        ++result_.num_own;
    }

    void add_clip(const MotionFile& file)
    {
        require_input(!maps_.empty(), "{}: needs a joint map, give --joint-map or --joint-maps", file.path);
        MotionClip clip = read_motion(file);
        const JointMap* map = find_joint_map(maps_, clip);
        if (map == nullptr) {
            require_input(file.from_folder,
                          "{}: no joint map fits its joints, {} lacks \"{}\" (propose-joint-map writes one)", file.path,
                          maps_.front().path, missing_source_joint(maps_.front(), clip));
            tell_(fmt::format("skipped {}: no joint map fits its joints", file.path));
            ++result_.num_unmapped;
            return;
        }
        clip.name = new_name(clip, file);
        if (clip.name.empty()) return;
        const ClipConventions found = apply_conventions(clip, *map, options_.conventions);
        RetargetReport report;
        PoseSet added = retarget_clip(clip, *map, joint_positions_, options_.retarget, report);
        if (options_.interpolate) added = resample_poses(added, frame_rate_);
        report.num_poses = added.size();
        report.path = file.path;
        report.metres_per_unit = found.metres_per_unit;
        report.unit_from = found.unit_from;
        report.performer_stature = found.performer_stature;
        report.up_axis = found.up;
        report.front_axis = found.front;
        report.axes_from = found.axes_from;
        tell_(conventions_line(report));
        if (added.size() == 0) log_warning("{}: no pose is left", file.path);
        append_poses(result_.poses, added);
        result_.reports.push_back(report);
    }

    /// "" for a take that has been read already.
    std::string new_name(const MotionClip& clip, const MotionFile& file)
    {
        const std::string name = names_.add(clip, file.path);
        if (name.empty()) {
            tell_(fmt::format("skipped {}: a take of this name and length has been read already", file.path));
            ++result_.num_copies;
        }
        return name;
    }

    MotionImportOptions options_;
    double frame_rate_ = options_.retarget.frame_rate;  ///< asked for
    Points joint_positions_;
    const std::function<void(const std::string&)>& tell_;
    std::vector<JointMap> maps_;
    std::optional<JointLimits> limits_;
    ClipNames names_;
    ImportedMotions result_;
};

}  // namespace

void MotionFiles::add(Tool& tool, bool required)
{
    tool.input("motion", motions, "BVH, AMC (ASF beside them), DeepMimic, AMASS or keyframe files, or folders",
               required);
    tool.input("joint-map", joint_map, "joint map for all clips", false);
    tool.input(
        "joint-maps", joint_maps,
        "folder of joint maps; each clip takes the one that fits its joints. Without it those that come with the "
        "program",
        false);
    tool.input("joint-limits", joint_limits,
               "ranges of motion to count violations of; without it those that come with the program", false);
}

void MotionFiles::complete()
{
    if (joint_map.empty() && joint_maps.empty()) joint_maps = installed_path("joint-maps");
    if (joint_limits.empty()) joint_limits = installed_path("joint-limits.json");
}

void describe(OptionList& list, MotionImportOptions& options)
{
    describe(list, options.retarget);
    describe(list, options.conventions);
    list.add("interpolate", options.interpolate,
             "poses exactly --frame-rate apart, also faster than the file's, by interpolation of rotations; otherwise "
             "the file's frames that lie nearest");
}

ImportedMotions import_motions(const MotionFiles& files, const MotionImportOptions& options,
                               const Eigen::Ref<const Points>& joint_positions,
                               const std::function<void(const std::string& line)>& tell)
{
    return MotionImport(files, options, joint_positions, tell).take();
}

}  // namespace ndg
