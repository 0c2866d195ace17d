// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/make_avatar.h"

#include "ndg/avatar/control_points.h"
#include "ndg/core/error.h"
#include "ndg/geometry/tetrahedralize.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ndg {

namespace {

/// Skin edges over which tetrahedra grow inside, on the average.
constexpr double default_edges = 1.5;

double mean_edge(const Points& vertices, const Triangles& triangles)
{
    double sum = 0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        for (int c = 0; c < 3; ++c)
            sum += (vertices.row(triangles(t, c)) - vertices.row(triangles(t, (c + 1) % 3))).norm();
    return sum / double(3 * triangles.rows());
}

Points select_rows(const Eigen::Ref<const Points>& points, const std::vector<int>& rows)
{
    Points selected(Eigen::Index(rows.size()), 3);
    for (std::size_t i = 0; i < rows.size(); ++i) selected.row(Eigen::Index(i)) = points.row(rows[i]);
    return selected;
}

void make_volume(Avatar& avatar, const SoftRegion& region, const AvatarOptions& options,
                 const Eigen::Ref<const RowMatrix>& region_control_weights)
{
    const Points outer = select_rows(avatar.skin_vertices, region.skin_vertices);
    const TriangleMesh surface = layer_surface(region, outer, inner_surface(outer, avatar.inward, avatar.thickness));
    const double edge =
        options.tetrahedron_edge > 0 ? options.tetrahedron_edge : default_edges * mean_edge(outer, region.triangles);
    // Of the regular tetrahedron, twice: those that TetGen makes are smaller than the bound.
    const double max_volume = 2 * edge * edge * edge / (6 * std::sqrt(2.0));
    fill_volume(avatar, region, tetrahedralize(surface.vertices, surface.triangles, max_volume),
                region_control_weights);
}

double mean(const std::vector<double>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

}  // namespace

void describe(OptionList& list, AvatarOptions& options)
{
    describe(list, options.layer);
    list.add("thickness", options.thickness, "thickness of the soft tissue where its bounds allow it, m", 1e-4, 1);
    list.add("control-points", options.control_points,
             "points whose values make a thickness or stiffness field, each with its mirror image", 1, 1000);
    list.add("tetrahedron-edge", options.tetrahedron_edge,
             "edge of the tetrahedra inside, m; 0: one and a half times that of the skin", 0, 1);
}

Avatar make_avatar(const StatisticalBody& body, const Eigen::Ref<const Eigen::VectorXd>& shape,
                   const AvatarOptions& options, const std::vector<double>& control_values, AvatarReport& report)
{
    check_options(options);
    const std::string defect = statistical_body_defect(body);
    require_input(defect.empty(), "the statistical body is not consistent: {}", defect);
    require_input(
        !body.soft_triangles.empty(),
        "the statistical body does not say where its soft tissue ends (/skin/soft_triangles); name the joints "
        "of head, hands and feet");
    Avatar avatar;
    avatar.skin_vertices = body.rest_vertices(shape);
    avatar.whole_skin_triangles = body.triangles;
    avatar.skin_weights = body.weights;
    avatar.pose_joints = body.pose_joints;
    avatar.skin_pose_directions = body.pose_directions;
    avatar.skeleton = body.skeleton;
    avatar.joint_positions = body.joint_positions(avatar.skin_vertices);

    const SoftRegion region = soft_region(avatar.skin_vertices, body.triangles, body.soft_triangles);
    const Points outer = select_rows(avatar.skin_vertices, region.skin_vertices);
    const SkeletonTree tree(body.skeleton, avatar.joint_positions, flesh_joints(region, body.weights));
    const SoftTissueLayer layer = soft_tissue_layer(outer, region, tree, options.layer);
    avatar.inward = layer.inward;
    avatar.min_thickness = layer.min_thickness;
    avatar.max_thickness = layer.max_thickness;

    const ControlPoints points = place_control_points(outer, options.control_points, avatar.joint_positions(0, 0));
    for (int c = 0; c < points.size(); ++c) {
        avatar.control_vertices.push_back(region.skin_vertices[points.vertices[c]]);
        avatar.mirror_vertices.push_back(points.mirrored[c] < 0 ? -1 : region.skin_vertices[points.mirrored[c]]);
    }
    avatar.skin_of_inner = region.skin_vertices;
    avatar.control_weights = control_point_weights(outer, region.triangles, points);
    const std::vector<double> uniform(points.vertices.size(), options.thickness);
    avatar.thickness = thickness_field(avatar, control_values.empty() ? uniform : control_values);
    report.num_unfolded =
        unfold_thickness(region, outer, layer.inward, layer.min_thickness, options.layer.max_slope, avatar.thickness);
    const RowMatrix region_control_weights = avatar.control_weights;
    make_volume(avatar, region, options, region_control_weights);

    report.num_turned = layer.num_turned;
    report.num_lowered = layer.num_lowered;
    report.num_thin = layer.num_thin;
    for (Eigen::Index t = 0; t < region.triangles.rows(); ++t)
        for (int c = 0; c < 3; ++c) {
            const int a = region.triangles(t, c), b = region.triangles(t, (c + 1) % 3);
            report.largest_stretch =
                std::max(report.largest_stretch, tree.distance(layer.projections[a], layer.projections[b]) /
                                                     (outer.row(a) - outer.row(b)).norm());
        }
    report.mean_thickness = mean(avatar.thickness);
    report.mean_max_thickness = mean(avatar.max_thickness);
    report.quality = tetrahedra_quality(avatar.rest, avatar.tetrahedra);
    return avatar;
}

VolumeChange change_thickness(Avatar& avatar, const std::vector<double>& thickness, const AvatarOptions& options)
{
    check_options(options);
    if (move_inner_surface(avatar, thickness)) return VolumeChange::same_tetrahedra;
    const SoftRegion region = avatar_region(avatar);
    avatar.thickness = thickness;
    unfold_thickness(region, select_rows(avatar.skin_vertices, region.skin_vertices), avatar.inward,
                     avatar.min_thickness, options.layer.max_slope, avatar.thickness);
    const RowMatrix region_control_weights = avatar.control_weights.topRows(region.size());
    make_volume(avatar, region, options, region_control_weights);
    return VolumeChange::new_tetrahedra;
}

}  // namespace ndg
