// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/sample_inputs.h"

#include "ndg/core/error.h"

namespace ndg {

void SampleInputs::add_files(Tool& tool)
{
    tool.input("template", template_path_, "template");
    tool.input("bodies", bodies_path_, "layered bodies");
    tool.input("poses", poses_path_, "poses", make_poses_ == nullptr);
}

void SampleInputs::add_files(Tool& tool, std::function<PoseSet(const Template&)> other_poses)
{
    make_poses_ = std::move(other_poses);
    add_files(tool);
}

void SampleInputs::add_splits(Tool& tool)
{
    with_splits_ = true;
    tool.input("splits", splits_path_, "splits and pairs; without it: --body", false);
    tool.parameter("body", body_idx_, "this body instead of --splits; -1: none", -1, 100000000);
    tool.parameter("pose", pose_idx_, "with --body, this pose; -1: all", -1, 100000000);
}

void SampleInputs::add_samples(Tool& tool)
{
    with_samples_ = true;
    add_splits(tool);
    tool.parameter("split", split, "whose pairs are taken; with --body, the split its samples are put in", split_names);
}

void SampleInputs::add_posing(Tool& tool)
{
    tool.options(samples.posing);
}

void SampleInputs::read()
{
    body_template = read_template(template_path_);
    bodies = read_bodies(bodies_path_, body_template);
    poses = other_poses() ? make_poses_(body_template) : read_poses(poses_path_);
    if (with_splits_) read_splits_or_body();
    if (!with_samples_) return;
    samples.pairs = splits.pairs.at(split);
    require_input(!samples.pairs.empty(), "{}: the split {} has no pairs", splits_path_, split);
    samples.pair_splits.assign(samples.pairs.size(), split);
}

void SampleInputs::read_splits_or_body()
{
    require_input(!other_poses() || splits_path_.empty(), "--splits goes with --poses");
    const bool all_bodies = other_poses() && body_idx_ < 0;
    require_input(all_bodies || splits_path_.empty() != (body_idx_ < 0),
                  "give either --splits or --body, not both or none");
    require_input(pose_idx_ < 0 || body_idx_ >= 0, "--pose goes with --body");
    const int num_bodies = int(bodies.bodies.size());
    if (body_idx_ < 0 && !all_bodies) {
        splits = read_splits(splits_path_, num_bodies, poses.size());
        return;
    }
    require_input(body_idx_ < num_bodies, "{}: has {} bodies, --body is {}", bodies_path_, num_bodies, body_idx_);
    require_input(pose_idx_ < poses.size(), "{}: has {} poses, --pose is {}",
                  other_poses() ? "the motion" : poses_path_, poses.size(), pose_idx_);
    for (const std::string& name : split_names) splits.pairs[name];
    for (int i = 0; i < poses.size(); ++i)
        if (pose_idx_ < 0 || i == pose_idx_) splits.poses[split].push_back(i);
    for (int b = all_bodies ? 0 : body_idx_; b < (all_bodies ? num_bodies : body_idx_ + 1); ++b) {
        splits.bodies[split].push_back(b);
        for (const int i : splits.poses[split]) splits.pairs[split].push_back({b, i});
    }
}

}  // namespace ndg
