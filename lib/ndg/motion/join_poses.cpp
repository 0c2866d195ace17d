// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/join_poses.h"

#include <set>
#include <string>

namespace ndg {

PoseSet join_poses(const std::vector<PoseSet>& sets)
{
    PoseSet joined;
    std::set<std::string> names;
    std::vector<int> clips_before;
    for (const PoseSet& set : sets) {
        clips_before.push_back(static_cast<int>(joined.clip_names.size()));
        for (const std::string& clip : set.clip_names) {
            std::string name = clip;
            for (int k = 2; names.count(name) > 0; ++k) name = clip + " " + std::to_string(k);
            names.insert(name);
            joined.clip_names.push_back(name);
        }
        joined.clip_frame_rates.insert(joined.clip_frame_rates.end(), set.clip_frame_rates.begin(),
                                       set.clip_frame_rates.end());
    }
    std::vector<Eigen::Matrix<int, 1, 6>> spliced_from;
    int num_drawn = 0;
    for (const bool spliced : {false, true}) {
        for (std::size_t s = 0; s < sets.size(); ++s) {
            const PoseSet& set = sets[s];
            for (int p = 0; p < set.size(); ++p) {
                if (set.is_spliced(p) != spliced) continue;
                joined.poses.push_back(set.poses[p]);
                joined.clip_idx.push_back(set.clip_idx[p] + clips_before[s]);
                joined.frame_idx.push_back(set.frame_idx[p]);
                if (!spliced) continue;
                spliced_from.emplace_back(set.spliced_from.row(p));
                for (const int column : {0, 2, 4}) spliced_from.back()[column] += clips_before[s];
            }
        }
        if (!spliced) num_drawn = joined.size();
    }
    if (spliced_from.empty()) return joined;
    joined.spliced_from = RowMatrixI::Constant(joined.size(), 6, -1);
    for (std::size_t k = 0; k < spliced_from.size(); ++k)
        joined.spliced_from.row(num_drawn + static_cast<Eigen::Index>(k)) = spliced_from[k];
    return joined;
}

}  // namespace ndg
