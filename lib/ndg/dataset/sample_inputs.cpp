// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/sample_inputs.h"

#include "ndg/core/error.h"
#include "ndg/dataset/splits.h"

namespace ndg {

void SampleInputs::add_files(Tool& tool)
{
    tool.input("template", template_path_, "template");
    tool.input("bodies", bodies_path_, "layered bodies");
    tool.input("poses", poses_path_, "poses");
}

void SampleInputs::add_samples(Tool& tool)
{
    with_samples_ = true;
    tool.input("splits", splits_path_, "splits and pairs; without it: --body", false);
    tool.parameter("split", split, "whose pairs are taken; with --body, the split its samples are put in", split_names);
    tool.parameter("body", body_idx_, "this body instead of --splits; -1: none", -1, 100000000);
    tool.parameter("pose", pose_idx_, "with --body, this pose; -1: all", -1, 100000000);
}

void SampleInputs::add_posing(Tool& tool)
{
    tool.options(samples.posing);
}

void SampleInputs::read()
{
    body_template = read_template(template_path_);
    bodies = read_bodies(bodies_path_, body_template);
    poses = read_poses(poses_path_);
    if (with_samples_) read_samples();
}

void SampleInputs::read_samples()
{
    require_input(splits_path_.empty() != (body_idx_ < 0), "give either --splits or --body, not both or none");
    require_input(pose_idx_ < 0 || body_idx_ >= 0, "--pose goes with --body");
    const int num_bodies = int(bodies.bodies.size());
    if (body_idx_ < 0) {
        samples.pairs = read_splits(splits_path_, num_bodies, poses.size()).pairs.at(split);
        require_input(!samples.pairs.empty(), "{}: the split {} has no pairs", splits_path_, split);
    } else {
        require_input(body_idx_ < num_bodies, "{}: has {} bodies, --body is {}", bodies_path_, num_bodies, body_idx_);
        require_input(pose_idx_ < poses.size(), "{}: has {} poses, --pose is {}", poses_path_, poses.size(), pose_idx_);
        for (int i = 0; i < poses.size(); ++i) {
            if (pose_idx_ < 0 || i == pose_idx_) samples.pairs.push_back({body_idx_, i});
        }
    }
    samples.pair_splits.assign(samples.pairs.size(), split);
}

}  // namespace ndg
