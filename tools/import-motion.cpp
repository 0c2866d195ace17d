// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/installed_files.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/motion/keyframes.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/retarget.h"
#include "ndg/retarget/retarget_units.h"

#include <fmt/format.h>

#include <optional>

using namespace ndg;

namespace {

void print_conventions(const RetargetReport& report)
{
    fmt::print("{}: unit {:.4g} m ({}), performer {:.2f} m tall; up {}, front {} ({}); {:.4g} Hz{}\n", report.clip_name,
               report.metres_per_unit, report.unit_from, report.performer_stature, report.up_axis, report.front_axis,
               report.axes_from, report.frame_rate, report.frame_rate_assumed ? " (assumed)" : "");
}

/// Motions of our own need no retargeting; their angles are those of any body.
PoseSet own_poses(const MotionFile& file, const Points& joint_positions, double frame_rate, ClipNames& names,
                  std::string& licences)
{
    const KeyframeMotion motion = read_keyframe_motion(file.path);
    PoseSet poses = keyframe_poses(motion, joint_positions, frame_rate);
    MotionClip clip;
    clip.name = motion.name;
    clip.frame_rate = motion.frame_rate;
    clip.world_from_joint.resize(motion.num_frames());
    poses.clip_names.front() = names.add(clip, file.path);
    if (licences.find(motion.licence) == std::string::npos) licences += (licences.empty() ? "" : "; ") + motion.licence;
    return poses;
}

}  // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> motion_paths;
    const std::string own_maps = installed_path("joint-maps");
    std::string template_path, map_path, maps_folder = own_maps, limits_path, output_path, report_path, licence;
    RetargetOptions options;
    ConventionOptions conventions;

    Tool tool("import-motion", "Brings motion capture onto the project's skeleton.",
              "import-motion --motion mocap/ --template template.h5 --joint-maps configs/joint-maps --joint-limits "
              "configs/joint-limits.json --output poses.h5 --report report.json");
    tool.input("motion", motion_paths, "BVH, AMC (ASF beside them), DeepMimic, AMASS or keyframe files, or folders");
    tool.input("template", template_path, "template whose rest joints the poses start from");
    tool.input("joint-map", map_path, "joint map for all clips", false);
    tool.input("joint-maps", maps_folder,
               "folder of joint maps; each clip takes the one that fits its joints. Without it those that come with "
               "the program",
               false);
    tool.input("joint-limits", limits_path, "ranges of motion to count violations of", false);
    tool.output("output", output_path, "poses to write");
    tool.output("report", report_path, "all figures of every clip, JSON", false);
    tool.options(options);
    tool.options(conventions);
    tool.parameter("licence", licence, "licence and credit line of the motions, kept in the output");

    return tool.run(argc, argv, [&] {
        require_input(map_path.empty() || maps_folder == own_maps,
                      "give one of --joint-map and --joint-maps, not both");
        require_input(!options.clamp_limits || !limits_path.empty(), "--clamp-joint-limits needs --joint-limits");
        const Points joint_positions = read_template(template_path).rest.joint_positions;
        std::vector<JointMap> maps;
        if (!map_path.empty()) {
            maps = {read_joint_map(map_path)};
            maps_folder.clear();  // is no input
        }
        if (!maps_folder.empty()) maps = read_joint_maps(maps_folder);
        std::optional<JointLimits> limits;
        if (!limits_path.empty()) limits.emplace(read_joint_limits(limits_path), joint_positions);
        options.limits = limits ? &*limits : nullptr;

        PoseSet poses;
        ClipNames names;
        std::vector<RetargetReport> reports;
        int num_copies = 0, num_unmapped = 0, num_own = 0;
        for (const MotionFile& file : find_motion_files(motion_paths)) {
            if (!file.skip_reason.empty()) {
                fmt::print("skipped {}: {}\n", file.path, file.skip_reason);
                continue;
            }
            if (file.keyframes) {
                const PoseSet own = own_poses(file, joint_positions, options.frame_rate, names, licence);
                if (own.clip_names.front().empty()) {
                    fmt::print("skipped {}: a take of this name and length has been read already\n", file.path);
                    ++num_copies;
                    continue;
                }
                fmt::print("{}: keyframes, {} poses\n", own.clip_names.front(), own.size());
                append_poses(poses, own);
                ++num_own;
                continue;
            }
            require_input(!maps.empty(), "{}: needs a joint map, give --joint-map or --joint-maps", file.path);
            MotionClip clip = read_motion(file);
            const JointMap* map = find_joint_map(maps, clip);
            if (map == nullptr) {
                require_input(file.from_folder, "{}: no joint map fits its joints, {} lacks \"{}\"", file.path,
                              maps.front().path, missing_source_joint(maps.front(), clip));
                fmt::print("skipped {}: no joint map fits its joints\n", file.path);
                ++num_unmapped;
                continue;
            }
            clip.name = names.add(clip, file.path);
            if (clip.name.empty()) {
                fmt::print("skipped {}: a take of this name and length has been read already\n", file.path);
                ++num_copies;
                continue;
            }
            const ClipConventions found = apply_conventions(clip, *map, conventions);
            RetargetReport report;
            const PoseSet added = retarget_clip(clip, *map, joint_positions, options, report);
            report.path = file.path;
            report.metres_per_unit = found.metres_per_unit;
            report.unit_from = found.unit_from;
            report.performer_stature = found.performer_stature;
            report.up_axis = found.up;
            report.front_axis = found.front;
            report.axes_from = found.axes_from;
            print_conventions(report);
            if (added.size() == 0) log_warning("{}: no pose is left", file.path);
            append_poses(poses, added);
            reports.push_back(report);
        }
        require_input(poses.size() > 0, "{}: gave no pose", motion_paths.front());
        write_poses(output_path, poses, tool.provenance(licence));
        if (!report_path.empty()) write_file(report_path, report_json(reports));
        if (!reports.empty()) fmt::print("{}", report_table(reports));
        fmt::print("{}: {} poses of {} motions; {} were copies of takes read before, {} had no joint map\n",
                   output_path, poses.size(), static_cast<int>(reports.size()) + num_own + num_copies + num_unmapped,
                   num_copies, num_unmapped);
    });
}
