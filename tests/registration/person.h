// SPDX-License-Identifier: Apache-2.0
// Other people in the tessellation of the coarse template.
#pragma once

#include "ndg/geometry/triangle_mesh.h"
#include "ndg/registration/articulated_model.h"
#include "scan/template_skin.h"

#include <cmath>

namespace ndg::test {

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
