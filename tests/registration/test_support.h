// SPDX-License-Identifier: Apache-2.0
// A coarse template without layers, made from the procedural body, and other people in its tessellation.
#pragma once

#include "ndg/body/template.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/point_tree.h"
#include "ndg/geometry/simplify.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/procedural/body.h"
#include "ndg/registration/articulated_model.h"
#include "ndg/scan/scan_simulation.h"

#include <catch2/catch.hpp>

#include <cmath>

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

/// Somebody else: taller by `growth`, trunk and thighs wider by `girth` (shares), with a belly of `belly` m.
inline SkinnedSurface person(double growth, double girth, double belly)
{
    const ArticulatedModel model(template_skin());
    Eigen::VectorXd parameters = Eigen::VectorXd::Zero(model.num_parameters());
    parameters[6] = std::log(1.0 + growth);
    // Breadth, height and depth of the four parts of the trunk come first among the scales.
    for (int part = 0; part < 4; ++part) {
        parameters[model.scale_begin() + 3 * part] = parameters[model.scale_begin() + 3 * part + 2] =
            std::log(1.0 + girth);
    }
    SkinnedSurface skin = template_skin();
    skin.vertices = model.rest_vertices(parameters);
    skin.joint_positions = model.rest_joints(parameters);
    const Points normals = vertex_normals(skin.vertices, skin.triangles);
    const Eigen::RowVector3d navel = skin.joint_positions.row(0) + Eigen::RowVector3d(0, 0.1, 0.12);
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        const double distance = (skin.vertices.row(v) - navel).norm();
        skin.vertices.row(v) += belly * std::exp(-std::pow(distance / 0.12, 2)) * normals.row(v);
    }
    return skin;
}

}  // namespace ndg::test
