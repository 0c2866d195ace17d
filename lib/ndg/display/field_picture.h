// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"
#include "ndg/scene/image.h"

#include <string>
#include <vector>

namespace ndg {

/// Values on some vertices of a skin.
struct SkinField {
    std::string label;
    Eigen::VectorXd values;  ///< one for each of the vertices that have one
};

/// A skin (N x 3, facing +z) from the front and from behind, a column a field: white is zero, full red `range` or more;
/// what has no value is grey. `vertices_with_values`: skin vertices, as many as every field has values. Throws Error
/// for other numbers, no field, or a range that is not positive.
Image skin_field_picture(const Points& vertices, const Triangles& triangles,
                         const std::vector<int>& vertices_with_values, const std::vector<SkinField>& fields,
                         double range, const std::string& footer, int height = 500);

}  // namespace ndg
