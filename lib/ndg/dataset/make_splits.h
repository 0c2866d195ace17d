// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/core/options.h"
#include "ndg/dataset/splits.h"

#include <array>
#include <cstdint>
#include <string>

namespace ndg {

/// Arrays are in the order of split_names: train, validation, test.
struct SplitOptions {
    std::array<double, 3> fractions = {0.8, 0.1, 0.1};  ///< of bodies and of poses, sum 1
    std::array<int, 3> num_pairs = {1, 1, 1};
    double segment_seconds = 4.0;
    double guard_seconds = 0.5;
    std::uint64_t seed = 0;
};
void describe(OptionList& list, SplitOptions& options);

/// Splits bodies and poses, and pairs them within each split (NDG 4.1).
/// Clips are cut into segments of segment_seconds and whole segments drawn for a split; where two neighbouring segments
/// fall into different splits, poses nearer than half of guard_seconds to their border go unused, so that poses of one
/// clip in different splits are at least guard_seconds apart. Of many random draws the one nearest to the fractions is
/// taken. Pairs are without repetition, and in every prefix of them each body and each pose is used equally often
/// within one. The same seed gives the same result.
/// Spliced poses serve training alone, those of which nothing comes from validation or testing; fractions are of the
/// others. Throws InputError where a split would be without body or pose, or where more pairs are asked for than exist.
Splits make_splits(int num_bodies, const PoseSet& poses, const SplitOptions& options);

/// All of `num_bodies` other bodies in all poses of one split of `known`, in that split: bodies that training never
/// saw, in poses that it never saw either. Throws InputError where the split has no pose.
Splits unseen_bodies_splits(const Splits& known, const std::string& split, int num_bodies);

}  // namespace ndg
