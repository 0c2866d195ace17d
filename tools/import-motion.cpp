// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/motion/motion_files.h"
#include "ndg/motion/retarget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

using namespace ndg;

namespace {

constexpr double radians_per_degree = M_PI / 180.0;

void print_skipped(const std::string& path, const std::string& reason)
{
    fmt::print("skipped {}: {}\n", path, reason);
}

void print_report(const RetargetReport& report, const MotionClip& clip)
{
    fmt::print(
        "{}: {} frames at {:.4g} Hz{}, {} poses; bones {:.1e} degrees off; fastest joint {:.0f} degrees/s, {} glitch "
        "frames; dropped {} poses as glitches, {} beyond the joint limit\n",
        report.clip_name, report.num_frames, clip.frame_rate, clip.frame_rate_assumed ? " (assumed)" : "",
        report.num_poses, report.mean_direction_error / radians_per_degree, report.max_joint_speed / radians_per_degree,
        report.num_glitch_frames, report.num_dropped_glitches, report.num_dropped_angles);
}

}  // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> motion_paths;
    std::string template_path, map_path, maps_folder, output_path, licence;
    RetargetOptions options;
    double max_speed = options.max_joint_speed / radians_per_degree, max_angle = 180.0;

    Tool tool("import-motion", "Brings motion capture onto the project's skeleton.",
              "import-motion --motion mocap/ --template template.h5 --joint-maps configs/joint-maps --output poses.h5");
    tool.input("motion", motion_paths, "BVH, AMC (ASF beside them), DeepMimic or AMASS files, or folders");
    tool.input("template", template_path, "template whose rest joints the poses start from");
    tool.input("joint-map", map_path, "joint map for all clips", false);
    tool.input("joint-maps", maps_folder, "folder of joint maps; each clip takes the one that fits its joints", false);
    tool.output("output", output_path, "poses to write");
    tool.parameter("frame-rate", options.frame_rate, "poses kept a second (Hz), 0: every frame", 0.0, 1000.0);
    tool.parameter("max-joint-speed", max_speed, "drop frames where a joint turns faster (degrees/s): glitches", 1.0,
                   1e9);
    tool.parameter("max-joint-angle", max_angle, "drop frames with a joint further from rest (degrees), 180: none", 0.0,
                   180.0);
    tool.parameter("licence", licence, "licence and credit line of the motions, kept in the output");

    return tool.run(argc, argv, [&] {
        require_input(map_path.empty() != maps_folder.empty(), "give one of --joint-map and --joint-maps");
        options.max_joint_speed = max_speed * radians_per_degree;
        options.max_joint_angle = max_angle * radians_per_degree;
        const Points joint_positions = read_template(template_path).rest.joint_positions;
        const std::vector<JointMap> maps =
            map_path.empty() ? read_joint_maps(maps_folder) : std::vector<JointMap>{read_joint_map(map_path)};

        PoseSet poses;
        ClipNames names;
        RetargetReport total;
        int num_clips = 0;
        for (const MotionFile& file : find_motion_files(motion_paths)) {
            if (!file.skip_reason.empty()) {
                print_skipped(file.path, file.skip_reason);
                continue;
            }
            MotionClip clip = read_motion(file);
            const JointMap* map = find_joint_map(maps, clip);
            if (map == nullptr) {
                require_input(file.from_folder, "{}: no joint map fits its joints, {} lacks \"{}\"", file.path,
                              maps.front().path, missing_source_joint(maps.front(), clip));
                print_skipped(file.path, "no joint map fits its joints");
                continue;
            }
            clip.name = names.add(clip, file.path);
            if (clip.name.empty()) {
                print_skipped(file.path, "a take of this name and length has been read already");
                continue;
            }
            RetargetReport report;
            const PoseSet added = retarget_clip(clip, *map, joint_positions, options, report);
            print_report(report, clip);
            if (added.size() == 0) log_warning("{}: no pose is left", file.path);
            append_poses(poses, added);
            ++num_clips;
            total.num_frames += report.num_frames;
            total.num_dropped_glitches += report.num_dropped_glitches;
            total.num_dropped_angles += report.num_dropped_angles;
        }
        require_input(poses.size() > 0, "{}: gave no pose", motion_paths.front());
        write_poses(output_path, poses, tool.provenance(licence));
        fmt::print("{}: {} poses of {} clips, {} frames; dropped {} as glitches, {} beyond the joint limit\n",
                   output_path, poses.size(), num_clips, total.num_frames, total.num_dropped_glitches,
                   total.num_dropped_angles);
    });
}
