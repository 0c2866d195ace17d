// SPDX-License-Identifier: Apache-2.0
// Samples of one body, one after the other, as a motion.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/page/page.h"

#include <vector>

namespace ndg {

/// Poses in their order as a motion, Hz: the rate of their clips, thinned as they are; 1.5 for poses that are no
/// motion.
double shown_frame_rate(const PoseSet& poses, const std::vector<int>& pose_indices);

/// The frames of a page: the samples of the first file from `first_sample` on that are of its body, in their order, at
/// most `num_frames` (0: all), with what each of the other files makes of them. Without credits. Keeps references to
/// all three. Throws InputError for a sample that is not there.
PageMotion page_motion(const BodySet& bodies, const PoseSet& poses, const std::vector<DeformationSet>& files,
                       int first_sample, int num_frames);

}  // namespace ndg
