// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/tool.h"
#include "ndg/motion/pose_sampling.h"

#include <fmt/format.h>

using namespace ndg;

int main(int argc, char** argv)
{
    std::string poses_path, output_path;
    int count = 150, first = -1;
    bool remove_root = true;

    Tool tool("sample-poses", "Keeps the farthest-point subset of poses, in the order they were picked.",
              "sample-poses --poses poses.h5 --count 150 --output sampled.h5");
    tool.input("poses", poses_path, "poses to choose from");
    tool.output("output", output_path, "sampled poses to write, with the covering radius after each");
    tool.parameter("count", count, "poses to keep", 1, 10000000);
    tool.parameter("first", first, "pose to start from, -1: drawn with the seed", -1, 100000000);
    tool.parameter("remove-root", remove_root,
                   "root to the origin, unrotated: without gravity it changes nothing of the body's shape");

    return tool.run(argc, argv, [&] {
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
        fmt::print("{}: {} of {} poses, first {}; covering radius {:.4f} rad after the first, {:.4f} rad after all\n",
                   output_path, kept.size(), poses.size(), first, sampling.covering_radius.front(),
                   sampling.covering_radius.back());
    });
}
