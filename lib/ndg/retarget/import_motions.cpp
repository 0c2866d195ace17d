// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/import_motions.h"

#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/core/installed_files.h"
#include "ndg/core/log.h"
#include "ndg/io/smpl_skeleton.h"
#include "ndg/motion/keyframes.h"
#include "ndg/motion/motion_files.h"
#include "ndg/motion/resample_poses.h"
#include "ndg/motion/same_motion.h"

#include <fmt/ranges.h>

#include <optional>

namespace ndg {

namespace {

/// What rigs call the end of a foot differs by as much.
constexpr double foot_allowance_degrees = 10;

std::string conventions_line(const RetargetReport& report)
{
    return fmt::format("{}: unit {:.4g} m ({}), performer {:.2f} m tall; up {}, front {} ({}); {:.4g} Hz{}",
                       report.clip_name, report.metres_per_unit, report.unit_from, report.performer_stature,
                       report.up_axis, report.front_axis, report.axes_from, report.frame_rate,
                       report.frame_rate_assumed ? " (assumed)" : "") +
           (report.reference == "zero pose" ? "" : "; reference: " + report.reference);
}

class MotionImport {
public:
    MotionImport(const MotionFiles& files, const MotionImportOptions& options,
                 const Eigen::Ref<const Points>& joint_positions, const std::function<void(const std::string&)>& tell)
        : options_(options), joint_positions_(joint_positions), tell_(tell)
    {
        require_input(!options.retarget.clamp_limits || !files.joint_limits.empty(),
                      "--clamp-joint-limits needs --joint-limits");
        for (const std::string& path : files.joint_map) named_maps_.push_back(read_joint_map(path));
        if (!files.joint_maps.empty()) maps_ = read_joint_maps(files.joint_maps);
        if (!files.rest_joints.empty()) amass_model_.emplace(files.rest_joints);
        if (!files.reference.empty()) {
            reference_ = read(find_motion_files({files.reference}).at(0));
            options_.conventions.reference = &reference_;
        }
        if (!files.joint_limits.empty()) limits_.emplace(read_joint_limits(files.joint_limits), joint_positions_);
        options_.retarget.limits = limits_ ? &*limits_ : nullptr;
        if (options_.interpolate) options_.retarget.frame_rate = 0.0;
        const std::vector<MotionFile> found = find_motion_files(files.motions);
        for (const MotionFile& file : found) {
            try {
                add(file);
            } catch (const InputError& error) {
                if (!file.from_folder) throw;
                tell_(fmt::format("failed {}", error.what()));
                result_.failures.emplace_back(error.what());
            }
        }
        if (!result_.failures.empty()) left_out_ = result_.failures.front();
        require_input(result_.poses.size() > 0, "{}: gave no pose{}", files.motions.front(),
                      left_out_.empty() ? std::string() : "; " + left_out_);
    }

    ImportedMotions take() { return std::move(result_); }

private:
    void add(const MotionFile& file)
    {
        if (!file.error.empty()) throw InputError(file.error);
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
        PoseSet poses = keyframe_poses(motion, joint_positions_, options_.retarget.frame_rate);
        if (is_copy(poses, "", file)) return;
        const std::string name = names_.add(file.path);
        poses.clip_names.front() = name;
        std::string& licences = result_.licences;
        if (licences.find(motion.licence) == std::string::npos)
            licences += (licences.empty() ? "" : "; ") + motion.licence;
        tell_(fmt::format("{}: keyframes, {} poses", name, poses.size()));
        keep(poses, "");
        ++result_.num_own;
    }

    void add_clip(const MotionFile& file)
    {
        require_input(!maps_.empty() || !named_maps_.empty(), "{}: needs a joint map, give --joint-map or --joint-maps",
                      file.path);
        MotionClip clip = read(file);
        set_rate(clip, file);
        std::optional<JointMap> map = find_joint_map(named_maps_, clip);
        if (!map) map = find_joint_map(maps_, clip);
        if (!map) {
            std::vector<JointMap> all = named_maps_;
            all.insert(all.end(), maps_.begin(), maps_.end());
            const std::string reason = fmt::format("no joint map fits its joints, {} (propose-joint-map writes one)",
                                                   nearest_joint_map(all, clip));
            require_input(file.from_folder, "{}: {}", file.path, reason);
            tell_(fmt::format("skipped {}: {}", file.path, reason));
            ++result_.num_unmapped;
            return;
        }
        const std::string rig = rig_of(clip);
        const ClipConventions found = apply_conventions(clip, *map, options_.conventions);
        RetargetReport report;
        PoseSet added = retarget_clip(clip, *map, joint_positions_, options_.retarget, report);
        if (options_.interpolate) added = resample_poses(added, frame_rate_);
        if (is_copy(added, rig, file)) return;
        report.clip_name = names_.add(file.path);
        added.clip_names.front() = report.clip_name;
        report.num_poses = added.size();
        report.path = file.path;
        report.metres_per_unit = found.metres_per_unit;
        report.unit_from = found.unit_from;
        report.performer_stature = found.performer_stature;
        report.up_axis = found.up;
        report.front_axis = found.front;
        report.axes_from = found.axes_from;
        report.reference = found.reference;
        tell_(conventions_line(report));
        for (const std::string& warning : found.warnings) log_warning("{}", warning);
        warn(report);
        keep(added, rig);
        result_.reports.push_back(report);
    }

    MotionClip read(const MotionFile& file) const { return read_motion(file, amass_model_ ? &*amass_model_ : nullptr); }

    void set_rate(MotionClip& clip, const MotionFile& file) const
    {
        constexpr double least = 1.0, most = 1000.0;
        if (options_.source_rate > 0.0) {
            clip.frame_rate = options_.source_rate;
            clip.frame_rate_assumed = false;
        }
        require_input(
            clip.frame_rate >= least && clip.frame_rate <= most,
            "{}: its frames are {:.4g} s apart ({:.4g} Hz), {:.0f} to {:.0f} Hz are plausible; give --source-rate",
            file.path, 1.0 / clip.frame_rate, clip.frame_rate, least, most);
    }

    void warn(const RetargetReport& report)
    {
        for (const DroppedJoint& dropped : report.dropped_joints) {
            left_out_ = fmt::format(
                "{}: {} poses are left out because {} is up to {:.0f} degrees from rest, its limit is {:.0f}",
                report.clip_name, dropped.num_poses, dropped.joint, dropped.max_angle / radians_per_degree,
                dropped.limit / radians_per_degree);
            log_warning("{}", left_out_);
        }
        if (report.num_poses == 0) log_warning("{}: no pose is left", report.clip_name);
        const SegmentError* worst = nullptr;
        const auto excess = [&](const SegmentError& error) {
            const bool is_foot = error.segment.find("foot") != std::string::npos;
            return error.mean / radians_per_degree - options_.max_segment_error -
                   (is_foot ? foot_allowance_degrees : 0);
        };
        for (const SegmentError& error : report.segment_errors)
            if (excess(error) > 0 && (worst == nullptr || excess(error) > excess(*worst))) worst = &error;
        if (worst == nullptr) return;
        result_.disagreements.push_back(
            fmt::format("{}: {} points {:.0f} degrees elsewhere than the source's in the mean, more than {:g}; look at "
                        "the joint map "
                        "{} and the reference pose ({})",
                        report.clip_name, worst->segment, worst->mean / radians_per_degree, options_.max_segment_error,
                        report.joint_map, report.reference));
        log_warning("{}", result_.disagreements.back());
    }

    /// What tells a rig from others: its joints, and where they are at the zero pose to a thousandth of its size.
    static std::string rig_of(const MotionClip& clip)
    {
        const double size = clip.zero_pose_positions.cwiseAbs().maxCoeff();
        std::string text = "rig";
        for (int j = 0; j < clip.num_joints(); ++j) {
            text += " " + clip.joint_names[std::size_t(j)];
            for (int k = 0; k < 3; ++k)
                text += fmt::format(" {:.0f}", size > 0.0 ? 1000.0 * clip.zero_pose_positions(j, k) / size : 0.0);
        }
        return text;
    }

    /// Whether the motion is there already; says so.
    bool is_copy(const PoseSet& poses, const std::string& rig, const MotionFile& file)
    {
        for (const Kept& other : kept_) {
            const PoseRange before = {&result_.poses, other.first, other.count}, now = {&poses, 0, poses.size()};
            if (!same_motion(before, now, other.rig == rig ? same_rig() : other_rig())) continue;
            tell_(fmt::format("skipped {}: the same motion as {}", file.path, other.name));
            if (!file.from_folder) log_warning("{}: the same motion as {}, which is kept", file.path, other.name);
            ++result_.num_copies;
            return true;
        }
        return false;
    }

    void keep(const PoseSet& poses, const std::string& rig)
    {
        kept_.push_back({rig, poses.clip_names.front(), result_.poses.size(), poses.size()});
        append_poses(result_.poses, poses);
    }

    struct Kept {
        std::string rig, name;  ///< rig: "" for keyframes
        int first, count;       ///< among the poses
    };

    MotionImportOptions options_;
    double frame_rate_ = options_.retarget.frame_rate;  ///< asked for
    Points joint_positions_;
    const std::function<void(const std::string&)>& tell_;
    std::vector<JointMap> named_maps_, maps_;
    MotionClip reference_;
    std::optional<SmplSkeleton> amass_model_;
    std::vector<Kept> kept_;
    std::string left_out_;  ///< why poses or files were left out last
    std::optional<JointLimits> limits_;
    ClipNames names_;
    ImportedMotions result_;
};

}  // namespace

void MotionFiles::add(Tool& tool, bool required)
{
    tool.input("motion", motions, "BVH, AMC (ASF beside them), DeepMimic, AMASS or keyframe files, or folders",
               required);
    tool.input("joint-map", joint_map, "joint map for all clips; of several each clip takes the one that fits", false);
    tool.input(
        "joint-maps", joint_maps,
        "folder of joint maps; each clip that no --joint-map fits takes the one that fits its joints. Without it, "
        "and without --joint-map, those that come with the program",
        false);
    tool.input("reference", reference,
               "motion of the same rig with a frame in which the performer stands straight (--reference-frame says "
               "which), for rigs whose zero pose is something else",
               false);
    tool.input("rest-joints", rest_joints,
               "for AMASS: .npz of the body model (SMPL, SMPL-H, SMPL-X) that the poses belong to, of which the rest "
               "joints are taken, with each file's shape; without it limbs are straight at rest, 5 to 7 degrees off",
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
    list.add("source-rate", options.source_rate, "frames a second of the files (Hz), 0: as they say", 0, 1000);
    list.add("max-segment-error", options.max_segment_error,
             "a clip disagrees with its source where limbs, trunk, hips or shoulders point elsewhere by more in the "
             "mean, feet by 10 more (degrees)",
             0, 180);
}

void ImportedMotions::check() const
{
    std::vector<std::string> all = failures;
    all.insert(all.end(), disagreements.begin(), disagreements.end());
    if (all.empty()) return;
    throw QualityError(fmt::format("{} files could not be read, {} clips disagree with their source: {}",
                                   failures.size(), disagreements.size(), fmt::join(all, "; ")));
}

ImportedMotions import_motions(const MotionFiles& files, const MotionImportOptions& options,
                               const Eigen::Ref<const Points>& joint_positions,
                               const std::function<void(const std::string& line)>& tell)
{
    return MotionImport(files, options, joint_positions, tell).take();
}

}  // namespace ndg
