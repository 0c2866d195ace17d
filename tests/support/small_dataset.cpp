// SPDX-License-Identifier: Apache-2.0
#include "support/small_dataset.h"

#include "ndg/core/hash.h"
#include "support/support.h"

namespace ndg::test {

SmallDataset small_dataset(int rings, int segments)
{
    SmallDataset dataset;
    dataset.body_template = tube_template(rings, segments);
    for (const double scale : {1.0, 1.1, 0.9, 1.05}) {
        Body body = dataset.body_template.rest;
        for (Points* points :
             {&body.volume_vertices, &body.skin_vertices, &body.interior_vertices, &body.joint_positions}) {
            *points *= scale;
        }
        body.name = "tube_" + std::to_string(dataset.bodies.bodies.size());
        dataset.bodies.bodies.push_back(body);
    }
    constexpr int num_poses = 25;
    for (int i = 0; i < num_poses; ++i) dataset.poses.poses.push_back(tube_pose(-0.9 + 0.075 * i));
    dataset.poses.clip_names = {"bends"};
    dataset.poses.clip_frame_rates = {30};
    for (int i = 0; i < num_poses; ++i) {
        dataset.poses.clip_idx.push_back(0);
        dataset.poses.frame_idx.push_back(i);
        const bool training = i < 18, validation = !training && i < 21;
        const std::string split = training ? "train" : validation ? "validation" : "test";
        dataset.splits.poses[split].push_back(i);
        for (const int body_idx : training ? std::vector<int>{0, 1} : std::vector<int>{validation ? 2 : 3}) {
            dataset.splits.pairs[split].push_back({body_idx, i});
        }
    }
    dataset.bodies.parameter_names = {"scale"};
    dataset.bodies.parameters.resize(static_cast<Eigen::Index>(dataset.bodies.bodies.size()), 1);
    dataset.bodies.parameters << 1.0, 1.1, 0.9, 1.05;
    dataset.splits.bodies = {{"train", {0, 1}}, {"validation", {2}}, {"test", {3}}};
    return dataset;
}

void write_small_dataset(const std::string& folder, const SmallDataset& dataset)
{
    write_template(folder + "/template.h5", dataset.body_template, {});
    BodySet bodies = dataset.bodies;
    bodies.template_sha256 = sha256_path(folder + "/template.h5");
    write_bodies(folder + "/bodies.h5", bodies, {});
    write_poses(folder + "/poses.h5", dataset.poses, {});
    write_splits(folder + "/splits.h5", dataset.splits, {});
}

}  // namespace ndg::test
