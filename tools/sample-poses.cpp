// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/random.h"
#include "ndg/core/tool.h"
#include "ndg/motion/pose_sampling.h"
#include "ndg/motion/range_of_motion.h"

#include <fmt/format.h>

#include <optional>
#include <set>

using namespace ndg;

int main(int argc, char** argv)
{
    std::string poses_path, template_path, limits_path, output_path, ranges_path;
    int count = 150, first = -1;
    bool remove_root = true;

    Tool tool("sample-poses", "Keeps the farthest-point subset of poses, in the order they were picked.",
              "sample-poses --poses poses.h5 --count 150 --output sampled.h5 --template template.h5 "
              "--joint-limits configs/joint-limits.json --range-of-motion ranges.json");
    tool.input("poses", poses_path, "poses to choose from");
    tool.input("template", template_path, "template the poses are of, for --range-of-motion", false);
    tool.input("joint-limits", limits_path, "published ranges, for --range-of-motion", false);
    tool.output("output", output_path, "sampled poses to write, with the covering radius after each");
    tool.output("range-of-motion", ranges_path, "how far each joint goes in the sampled poses, JSON; also printed",
                false);
    tool.parameter("count", count, "poses to keep", 1, 10000000);
    tool.parameter("first", first, "pose to start from, -1: drawn with the seed", -1, 100000000);
    tool.parameter("remove-root", remove_root,
                   "root to the origin, unrotated: without gravity it changes nothing of the body's shape");

    return tool.run(argc, argv, [&] {
        require_input(ranges_path.empty() || !template_path.empty(), "--range-of-motion needs --template");
        PoseSet poses = read_poses(poses_path);
        require_input(count <= poses.size(), "{}: has {} poses, --count asks for {}", poses_path, poses.size(), count);
        require_input(first < poses.size(), "{}: has {} poses, --first is {}", poses_path, poses.size(), first);
        if (remove_root) {
            for (Pose& pose : poses.poses) remove_root_motion(pose);
        }
        if (first < 0) {
            Random random(tool.seed(), "first pose");
            first = static_cast<int>(random.below(static_cast<std::uint64_t>(poses.size())));
        }
        const PoseSampling sampling = farthest_point_sampling(poses.poses, count, first);

        PoseSet kept;
        kept.clip_names = poses.clip_names;
        kept.clip_frame_rates = poses.clip_frame_rates;
        kept.covering_radius = sampling.covering_radius;
        for (const int idx : sampling.order) {
            kept.poses.push_back(poses.poses[idx]);
            kept.clip_idx.push_back(poses.clip_idx[idx]);
            kept.frame_idx.push_back(poses.frame_idx[idx]);
        }
        write_poses(output_path, kept, tool.provenance());
        if (!ranges_path.empty()) {
            std::optional<JointLimitTable> limits;
            if (!limits_path.empty()) limits = read_joint_limits(limits_path);
            const RangeOfMotion ranges =
                range_of_motion(kept, read_template(template_path).rest.joint_positions, limits ? &*limits : nullptr);
            write_file(ranges_path, range_of_motion_json(ranges));
            fmt::print("{}", range_of_motion_table(ranges));
        }
        const std::set<int> clips(kept.clip_idx.begin(), kept.clip_idx.end());
        fmt::print(
            "{}: {} of {} poses from {} of {} clips, first {}; covering radius {:.4f} rad after the first, {:.4f} "
            "rad after all\n",
            output_path, kept.size(), poses.size(), clips.size(), poses.clip_names.size(), first,
            sampling.covering_radius.front(), sampling.covering_radius.back());
    });
}
