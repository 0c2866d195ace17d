// SPDX-License-Identifier: Apache-2.0
// A coarse template without layers, made from the procedural body.
#pragma once

#include "ndg/body/template.h"
#include "ndg/geometry/point_tree.h"
#include "ndg/geometry/simplify.h"
#include "ndg/procedural/body.h"
#include "ndg/scan/skin_places.h"

namespace ndg::test {

inline const Template& skin_template()
{
    static const Template result = [] {
        const ProceduralBody body;
        const ParametricSurface surface = body.evaluate({});
        const TriangleMesh coarse = simplify_closed({surface.vertices, surface.triangles}, 2600);
        const PointTree tree(surface.vertices);
        RowMatrix weights(coarse.vertices.rows(), body.weights().cols());
        for (Eigen::Index v = 0; v < weights.rows(); ++v) {
            weights.row(v) = body.weights().row(tree.nearest(coarse.vertices.row(v).transpose()).idx);
        }
        Template t;
        t.skeleton = standard_skeleton();
        t.skin_triangles = coarse.triangles;
        t.skin_weights = sparsify_weights(weights);
        t.rest.skin_vertices = coarse.vertices;
        t.rest.joint_positions = surface.joint_positions;
        t.landmarks.push_back({"first", 0, {1.0, 0.0, 0.0}});
        return t;
    }();
    return result;
}

inline const SkinnedSurface& template_skin()
{
    static const SkinnedSurface skin = {skin_template().rest.skin_vertices, skin_template().skin_triangles,
                                        skin_template().skin_weights, skin_template().rest.joint_positions};
    return skin;
}

}  // namespace ndg::test
