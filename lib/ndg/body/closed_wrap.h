// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// The bone wrap closed over the cuts: its vertices, then one centre for each cap.
struct ClosedBoneWrap {
    Points vertices;
    Triangles triangles;
};
ClosedBoneWrap close_bone_wrap(const Eigen::Ref<const Points>& bone_wrap,
                               const Eigen::Ref<const Triangles>& wrap_triangles);

}  // namespace ndg
