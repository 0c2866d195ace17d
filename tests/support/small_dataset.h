// SPDX-License-Identifier: Apache-2.0
// Files of a dataset small enough to simulate in a second or two: tubes in several sizes and bends.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/splits.h"
#include "ndg/body/template.h"

#include <string>

namespace ndg::test {

struct SmallDataset {
    Template body_template;
    BodySet bodies;  ///< the tube in four sizes
    PoseSet poses;   ///< 25 bends of its elbow
    Splits splits;   ///< 43 pairs: 36 for training (two bodies), 3 for validation, 4 for testing
};

/// The tube has `rings` rings of `segments` vertices.
SmallDataset small_dataset(int rings, int segments);
/// template.h5, bodies.h5, poses.h5 and splits.h5.
void write_small_dataset(const std::string& folder, const SmallDataset& dataset);

}  // namespace ndg::test
