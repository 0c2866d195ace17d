// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/sample_frames.h"

#include "ndg/core/error.h"

#include <algorithm>

namespace ndg {

double shown_frame_rate(const PoseSet& poses, const std::vector<int>& pose_indices)
{
    constexpr double no_motion = 1.5;
    double rate = 0.0;
    bool in_clip = false;  // the pose before has a neighbour in its clip
    for (std::size_t k = 1; k < pose_indices.size(); ++k) {
        const int before = pose_indices[k - 1], now = pose_indices[k];
        if (poses.clip_idx[now] != poses.clip_idx[before]) {
            if (!in_clip) return no_motion;
            in_clip = false;
            continue;
        }
        const int step = poses.frame_idx[now] - poses.frame_idx[before];
        if (step <= 0) return no_motion;
        const double rate_here = poses.clip_frame_rates[poses.clip_idx[now]] / step;
        if (rate > 0.0 && rate_here != rate) return no_motion;
        rate = rate_here;
        in_clip = true;
    }
    return in_clip ? rate : no_motion;
}

PageMotion page_motion(const BodySet& bodies, const PoseSet& poses, const std::vector<DeformationSet>& files,
                       int first_sample, int num_frames)
{
    require_input(!files.empty(), "--page needs --deformations: the samples to show, of one method or several");
    const DeformationSet& reference = files[0];
    require_input(first_sample < reference.size(), "--sample {} lies outside the {} samples of the {} file",
                  first_sample, reference.size(), reference.method);
    const int body_idx = reference.pairs[first_sample].body_idx;
    std::vector<std::vector<int>> samples(files.size());  // file, frame
    std::vector<int> pose_indices;
    PageMotion motion;
    for (int s = first_sample; s < reference.size(); ++s) {
        if (num_frames > 0 && int(motion.poses.size()) == num_frames) break;
        const SamplePair& pair = reference.pairs[s];
        if (pair.body_idx != body_idx) continue;
        require_pair(pair, bodies.bodies.size(), poses.poses.size());
        for (std::size_t f = 0; f < files.size(); ++f) {
            const std::vector<SamplePair>& pairs = files[f].pairs;
            const auto found = std::find(pairs.begin(), pairs.end(), pair);
            require_input(found != pairs.end(), "the {} file has no sample of {}", files[f].method, describe(pair));
            samples[f].push_back(int(found - pairs.begin()));
        }
        motion.poses.push_back(poses.poses[pair.pose_idx]);
        pose_indices.push_back(pair.pose_idx);
    }
    motion.body = &bodies.bodies[body_idx];
    motion.frame_rate = shown_frame_rate(poses, pose_indices);
    motion.title = fmt::format("{}, {}", motion.body->name, poses.clip_names[poses.clip_idx[pose_indices.front()]]);
    for (std::size_t f = 0; f < files.size(); ++f)
        motion.methods.push_back({files[f].method, [&file = files[f], chosen = samples[f]](int frame) {
                                      return file.points(chosen[frame]);
                                  }});
    return motion;
}

}  // namespace ndg
