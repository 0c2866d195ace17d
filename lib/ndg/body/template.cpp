// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"

#include "ndg/core/error.h"

namespace ndg {

SkinningWeights Template::volume_weights() const
{
    std::vector<int> rows;
    rows.reserve(3 * wrap_to_skin.size());
    for (int layer = 0; layer < 3; ++layer) rows.insert(rows.end(), wrap_to_skin.begin(), wrap_to_skin.end());
    return select_weights(skin_weights, rows);
}

SkinningWeights Template::prism_weights() const
{
    return element_weights(volume_weights(), prisms, skeleton.num_joints());
}

Prisms layer_prisms(const Eigen::Ref<const Triangles>& wrap_triangles, int num_wrap_vertices)
{
    const Eigen::Index count = wrap_triangles.rows();
    Prisms prisms(2 * count, 6);
    prisms.topRows(count) << wrap_triangles.array() + num_wrap_vertices, wrap_triangles;
    prisms.bottomRows(count) << wrap_triangles.array() + 2 * num_wrap_vertices,
        wrap_triangles.array() + num_wrap_vertices;
    return prisms;
}

}  // namespace ndg
