// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/random.h"
#include "ndg/core/tool.h"
#include "ndg/motion/join_poses.h"
#include "ndg/motion/pose_sampling.h"
#include "ndg/motion/pose_splicing.h"
#include "ndg/motion/range_of_motion.h"

#include <fmt/ranges.h>

#include <optional>
#include <set>

using namespace ndg;

int main(int argc, char** argv)
{
    std::vector<std::string> poses_paths;
    std::string template_path, limits_path, output_path, ranges_path;
    int count = 150, first = -1, spliced = 0;
    bool remove_root = true, all_joints = false;

    Tool tool("sample-poses", "Keeps the farthest-point subset of poses, in the order they were picked.",
              "sample-poses --poses poses.h5 --count 150 --output sampled.h5 --template template.h5 "
              "--joint-limits configs/joint-limits.json --range-of-motion ranges.json");
    tool.input("poses", poses_paths, "poses to choose from; several files are joined");
    tool.input("template", template_path,
               "template the poses are of; not needed with --all-joints and without --spliced and --range-of-motion",
               false);
    tool.input("joint-limits", limits_path, "published ranges, for --range-of-motion", false);
    tool.output("output", output_path, "sampled poses to write, with the covering radius after each");
    tool.output("range-of-motion", ranges_path, "how far each joint goes in the sampled poses, JSON; also printed",
                false);
    tool.parameter("count", count, "poses to keep; 0: all, in the files' order", 0, 10000000);
    tool.parameter("first", first, "pose to start from, -1: drawn with the seed", -1, 100000000);
    tool.parameter("all-joints", all_joints,
                   "distance over all joints; otherwise over those that move flesh (no fingers, jaw, eyes)");
    tool.parameter("spliced", spliced,
                   "poses to add: trunk and head of one, arms of another, legs of a third; they serve training", 0,
                   10000000);
    tool.parameter("remove-root", remove_root,
                   "root to the origin, unrotated: without gravity it changes nothing of the body's shape");

    return tool.run(argc, argv, [&] {
        require_input(ranges_path.empty() || !template_path.empty(), "--range-of-motion needs --template");
        require_input(all_joints || count == 0 || !template_path.empty(),
                      "which joints move flesh is the template's to tell: give --template, or --all-joints");
        require_input(spliced == 0 || !template_path.empty(), "--spliced needs --template");
        std::optional<Template> body_template;
        if (!template_path.empty()) body_template = read_template(template_path);
        std::vector<PoseSet> sets;
        for (const std::string& path : poses_paths) sets.push_back(read_poses(path));
        PoseSet poses = join_poses(sets);
        const std::string poses_path = fmt::format("{}", fmt::join(poses_paths, ", "));
        require_input(count <= poses.size(), "{}: has {} poses, --count asks for {}", poses_path, poses.size(), count);
        require_input(first < poses.size(), "{}: has {} poses, --first is {}", poses_path, poses.size(), first);
        if (remove_root) {
            for (Pose& pose : poses.poses) remove_root_motion(pose);
        }
        if (count == 0) {
            require_input(spliced == 0 && ranges_path.empty(),
                          "--count 0 keeps all poses: --spliced and --range-of-motion need a count");
            write_poses(output_path, poses, tool.provenance());
            fmt::print("{}: all {} poses of {} clips\n", output_path, poses.size(), poses.clip_names.size());
            return;
        }
        if (first < 0) {
            Random random(tool.seed(), "first pose");
            first = static_cast<int>(random.below(static_cast<std::uint64_t>(poses.size())));
        }
        const std::vector<int> marked =
            all_joints ? std::vector<int>(num_standard_joints, 1) : body_template->visible_joints();
        const PoseSampling sampling = farthest_point_sampling(with_marked_joints(poses.poses, marked), count, {first});

        PoseSet kept;
        kept.clip_names = poses.clip_names;
        kept.clip_frame_rates = poses.clip_frame_rates;
        kept.covering_radius = sampling.covering_radius;
        for (const int idx : sampling.order) {
            kept.poses.push_back(poses.poses[idx]);
            kept.clip_idx.push_back(poses.clip_idx[idx]);
            kept.frame_idx.push_back(poses.frame_idx[idx]);
        }
        if (spliced > 0) append_spliced(kept, poses, *body_template, marked, spliced, tool.seed());
        write_poses(output_path, kept, tool.provenance());
        if (!ranges_path.empty()) {
            std::optional<JointLimitTable> limits;
            if (!limits_path.empty()) limits = read_joint_limits(limits_path);
            const RangeOfMotion ranges =
                range_of_motion(kept, body_template->rest.joint_positions, limits ? &*limits : nullptr);
            write_file(ranges_path, range_of_motion_json(ranges));
            fmt::print("{}", range_of_motion_table(ranges));
        }
        const std::set<int> clips(kept.clip_idx.begin(), kept.clip_idx.begin() + count);
        fmt::print(
            "{}: {} of {} poses from {} of {} clips, first {}; covering radius {:.4f} rad after the first, {:.4f} "
            "rad after all\n",
            output_path, count, poses.size(), clips.size(), poses.clip_names.size(), first,
            sampling.covering_radius.front(), sampling.covering_radius.back());
        if (spliced > 0)
            fmt::print("and {} spliced ones; covering radius {:.4f} rad of those drawn\n", spliced,
                       kept.covering_radius.back());
    });
}
