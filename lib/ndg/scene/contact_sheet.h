// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/scene/body_surfaces.h"
#include "ndg/scene/camera.h"
#include "ndg/scene/image.h"

#include <vector>

namespace ndg {

struct ContactSheetSettings {
    View view = View::three_quarter;
    int columns = 0;        ///< thumbnails a row; 0: so many that the sheet is about half as wide again as it is high
    int cell_height = 200;  ///< pixels of one thumbnail with its caption
    int samples_per_axis = 2;
};

/// A grid of one body skinned to poses, each thumbnail with the pose's index and, below it, its clip and frame. All
/// are drawn at one scale, each seen from the same side of its pelvis. `pose_indices` into `poses`, in the order shown.
/// Throws InputError for no pose or an index out of range.
Image contact_sheet(const BodyPoser& poser, const Body& body, const PoseSet& poses,
                    const std::vector<int>& pose_indices, const ContactSheetSettings& settings);

}  // namespace ndg
