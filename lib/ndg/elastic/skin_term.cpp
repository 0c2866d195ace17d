// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/skin_term.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

namespace ndg {

namespace {

Stencils hinges(const Eigen::Ref<const Triangles>& triangles, int num_vertices)
{
    std::vector<int> corners;
    for (const MeshEdge& edge : mesh_edges(triangles, num_vertices)) {
        if (edge.right_triangle < 0) continue;
        corners.insert(corners.end(), {edge.v0, edge.v1, edge.left_vertex, edge.right_vertex});
    }
    return Stencils(4, std::move(corners), num_vertices, {{2, 3}});
}

}  // namespace

SkinTerm::SkinTerm(const Eigen::Ref<const Triangles>& triangles, double stretch_stiffness, double bend_stiffness,
                   int num_vertices)
    : LaneTerm<SkinLanes>(hinges(triangles, num_vertices)),
      stretch_stiffness_(stretch_stiffness),
      bend_stiffness_(bend_stiffness)
{
    rests_.resize(stencils().size());
}

void SkinTerm::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    for (int e = 0; e < stencils().size(); ++e) {
        const int* v = stencils().corners(e);
        const auto position = [&](int a) -> Eigen::Vector3d { return rest_vertices.row(v[a]).transpose(); };
        const Hinge hinge{position(0), position(1), position(2), position(3)};
        const Eigen::Vector3d along = hinge.x1 - hinge.x0;
        SkinEdgeRest& rest = rests_[e];
        rest.length = along.norm();
        rest.stretch_stiffness = stretch_stiffness_;
        rest.bend.left_area = 0.5 * along.cross(hinge.left - hinge.x0).norm();
        rest.bend.right_area = 0.5 * along.cross(hinge.right - hinge.x0).norm();
        require(rest.bend.left_area > 0 && rest.bend.right_area > 0,
                "the skin triangles at volume vertices {} and {} have rest areas {} and {} m^2", v[0], v[1],
                rest.bend.left_area, rest.bend.right_area);
        rest.bend.angle = dihedral_angle(hinge.x0, hinge.x1, hinge.left, hinge.right);
        rest.bend.weight =
            3 * bend_stiffness_ * rest.length * rest.length / (rest.bend.left_area + rest.bend.right_area);
    }
}

}  // namespace ndg
