// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/layer_volume.h"

#include "ndg/avatar/volume_interpolation.h"
#include "ndg/core/error.h"
#include "ndg/geometry/tetrahedra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr double least_weight = 1e-5;
/// Columns solved for together.
constexpr Eigen::Index block = 256;
/// A tetrahedron that is moved keeps at least this radius ratio; below, the volume is better made anew.
constexpr double least_moved_ratio = 1e-3;

double radius_ratio(const std::array<Eigen::Vector3d, 4>& x)
{
    const double volume = tetrahedron_volume(x[0], x[1], x[2], x[3]);
    double area = 0;
    for (int f = 0; f < 4; ++f) {
        const Eigen::Vector3d &a = x[(f + 1) % 4], &b = x[(f + 2) % 4], &c = x[(f + 3) % 4];
        area += 0.5 * (b - a).cross(c - a).norm();
    }
    // Circumscribed radius by the products of opposite edges (Crelle).
    const double p = (x[1] - x[0]).norm() * (x[3] - x[2]).norm(), q = (x[2] - x[0]).norm() * (x[3] - x[1]).norm(),
                 r = (x[3] - x[0]).norm() * (x[2] - x[1]).norm();
    const double product = (p + q + r) * (p + q - r) * (p - q + r) * (-p + q + r);
    if (volume == 0.0 || !(product > 0.0)) return 0.0;
    const double inscribed = 3 * volume / area, circumscribed = std::sqrt(product) / (24 * std::abs(volume));
    return 3 * inscribed / circumscribed;
}

std::array<Eigen::Vector3d, 4> corners_of(const Eigen::Ref<const Points>& vertices,
                                          const Eigen::Ref<const Tetrahedra>& tetrahedra, Eigen::Index t)
{
    std::array<Eigen::Vector3d, 4> corners;
    for (int c = 0; c < 4; ++c) corners[c] = vertices.row(tetrahedra(t, c)).transpose();
    return corners;
}

/// Rows of `directions` (features x 3 N) at the outer vertices, carried to all volume vertices: features x 3 M.
RowMatrixF carried_directions(const VolumeInterpolation& interpolation, const RowMatrixF& directions,
                              const SoftRegion& region, Eigen::Index num_vertices)
{
    RowMatrixF carried(directions.rows(), 3 * num_vertices);
    const Eigen::Index features_a_block = std::max<Eigen::Index>(1, block / 3);
    for (Eigen::Index begin = 0; begin < directions.rows(); begin += features_a_block) {
        const Eigen::Index count = std::min(features_a_block, directions.rows() - begin);
        RowMatrix values = RowMatrix::Zero(num_vertices, 3 * count);
        for (int w = 0; w < region.size(); ++w)
            for (Eigen::Index f = 0; f < count; ++f)
                values.row(region.outer[w]).segment<3>(3 * f) =
                    directions.row(begin + f).segment<3>(3 * region.skin_vertices[w]).cast<double>();
        const RowMatrix all = interpolation.interpolate(values);
        for (Eigen::Index v = 0; v < num_vertices; ++v)
            for (Eigen::Index f = 0; f < count; ++f)
                carried.row(begin + f).segment<3>(3 * v) = all.row(v).segment<3>(3 * f).cast<float>();
    }
    return carried;
}

}  // namespace

void fill_volume(Avatar& avatar, const SoftRegion& region, const TetrahedralMesh& mesh,
                 const Eigen::Ref<const RowMatrix>& region_control_weights)
{
    const Eigen::Index m = mesh.vertices.rows(), k = avatar.num_joints();
    const int w = region.size();
    require(m >= 2 * w && region_control_weights.rows() == w, "a volume of {} vertices was filled for a region of {}",
            m, w);
    avatar.rest = mesh.vertices;
    avatar.tetrahedra = mesh.tetrahedra;
    avatar.num_held = w + int(region.rim.size());
    avatar.skin_of_inner = region.skin_vertices;
    avatar.volume_vertex_of_skin.assign(region.region_of_skin.size(), -1);
    for (int v = 0; v < w; ++v) avatar.volume_vertex_of_skin[region.skin_vertices[v]] = region.outer[v];
    avatar.skin_triangles.resize(region.triangles.rows(), 3);
    for (Eigen::Index t = 0; t < region.triangles.rows(); ++t)
        for (int c = 0; c < 3; ++c) avatar.skin_triangles(t, c) = region.outer[region.triangles(t, c)];

    std::vector<bool> is_outer(m, false), on_boundary(m, false);
    std::fill(on_boundary.begin(), on_boundary.begin() + 2 * w, true);
    for (const int outer : region.outer) is_outer[outer] = true;
    const VolumeInterpolation from_outer(avatar.rest, avatar.tetrahedra, is_outer);

    const Points skin_normals = vertex_normals(avatar.skin_vertices, avatar.whole_skin_triangles);
    RowMatrix values = RowMatrix::Zero(m, k + 3);
    const RowMatrix skin_weights = avatar.skin_weights;
    for (int v = 0; v < w; ++v)
        values.row(region.outer[v]) << skin_weights.row(region.skin_vertices[v]),
            skin_normals.row(region.skin_vertices[v]);
    values = from_outer.interpolate(values);
    avatar.normals = values.rightCols(3).rowwise().normalized();
    RowMatrix weights = values.leftCols(k);
    for (Eigen::Index v = 0; v < m; ++v) {
        if (is_outer[v]) continue;
        weights.row(v) = (weights.row(v).array() < least_weight).select(0.0, weights.row(v));
        weights.row(v) /= weights.row(v).sum();
    }
    avatar.weights = sparse_weights(weights);
    for (Eigen::Index v = 0; v < m; ++v)
        require(avatar.normals.row(v).squaredNorm() > 0.5, "volume vertex {} got no normal", v);
    avatar.pose_directions = carried_directions(from_outer, avatar.skin_pose_directions, region, m);

    RowMatrix control = RowMatrix::Zero(m, region_control_weights.cols());
    for (int v = 0; v < w; ++v) control.row(v) = control.row(region.outer[v]) = region_control_weights.row(v);
    control = VolumeInterpolation(avatar.rest, avatar.tetrahedra, on_boundary).interpolate(control).cwiseMax(0.0);
    for (Eigen::Index v = 0; v < m && control.cols() > 0; ++v) control.row(v) /= control.row(v).sum();
    avatar.control_weights = control;
}

SoftRegion avatar_region(const Avatar& avatar)
{
    SoftRegion region;
    region.skin_vertices = avatar.skin_of_inner;
    region.region_of_skin.assign(avatar.volume_vertex_of_skin.size(), -1);
    std::vector<int> region_of_volume(avatar.rest.rows(), -1);
    for (int v = 0; v < region.size(); ++v) {
        const int skin = region.skin_vertices[v], outer = avatar.volume_vertex_of_skin[skin];
        region.region_of_skin[skin] = v;
        region.outer.push_back(outer);
        region_of_volume[outer] = v;
        if (outer < avatar.num_held) region.rim.push_back(v);
    }
    region.triangles = avatar.skin_triangles.unaryExpr([&](int outer) { return region_of_volume[outer]; });
    return region;
}

std::vector<double> thickness_field(const Avatar& avatar, const std::vector<double>& control_values)
{
    const Eigen::Index c = avatar.control_weights.cols();
    require_input(Eigen::Index(control_values.size()) == c, "{} thicknesses were given for {} control points",
                  control_values.size(), c);
    for (std::size_t i = 0; i < control_values.size(); ++i)
        require_input(std::isfinite(control_values[i]) && control_values[i] > 0,
                      "the thickness at control point {} is {} m", i, control_values[i]);
    const auto w = Eigen::Index(avatar.skin_of_inner.size());
    const Eigen::VectorXd values =
        avatar.control_weights.topRows(w) * Eigen::Map<const Eigen::VectorXd>(control_values.data(), c);
    std::vector<double> thickness(w);
    for (Eigen::Index v = 0; v < w; ++v)
        thickness[v] = std::clamp(values[v], avatar.min_thickness[v], avatar.max_thickness[v]);
    return thickness;
}

bool move_inner_surface(Avatar& avatar, const std::vector<double>& thickness)
{
    const auto w = Eigen::Index(avatar.skin_of_inner.size());
    require_input(Eigen::Index(thickness.size()) == w, "{} thicknesses were given for {} vertices of the inner surface",
                  thickness.size(), w);
    RowMatrix moved = RowMatrix::Zero(avatar.rest.rows(), 3);
    std::vector<bool> on_boundary(avatar.rest.rows(), false);
    std::fill(on_boundary.begin(), on_boundary.begin() + 2 * w, true);
    for (Eigen::Index v = 0; v < w; ++v) {
        // Stored in single precision by some, bounds are met to rounding.
        require_input(thickness[v] >= avatar.min_thickness[v] - 1e-6 && thickness[v] <= avatar.max_thickness[v] + 1e-6,
                      "the thickness of inner vertex {} is {} m, outside its bounds {} and {} m", v, thickness[v],
                      avatar.min_thickness[v], avatar.max_thickness[v]);
        moved.row(v) = (thickness[v] - avatar.thickness[v]) * avatar.inward.row(v);
    }
    const Points rest =
        avatar.rest + VolumeInterpolation(avatar.rest, avatar.tetrahedra, on_boundary).interpolate(moved);
    for (Eigen::Index t = 0; t < avatar.tetrahedra.rows(); ++t) {
        const auto corners = corners_of(rest, avatar.tetrahedra, t);
        if (!(tetrahedron_volume(corners[0], corners[1], corners[2], corners[3]) > 0.0) ||
            radius_ratio(corners) < least_moved_ratio)
            return false;
    }
    avatar.rest = rest;
    avatar.thickness = thickness;
    return true;
}

TetrahedraQuality tetrahedra_quality(const Eigen::Ref<const Points>& vertices,
                                     const Eigen::Ref<const Tetrahedra>& tetrahedra)
{
    TetrahedraQuality quality;
    constexpr double unbounded = std::numeric_limits<double>::max();
    quality.least_dihedral = quality.least_radius_ratio = quality.least_volume = unbounded;
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        const auto x = corners_of(vertices, tetrahedra, t);
        const double volume = tetrahedron_volume(x[0], x[1], x[2], x[3]);
        quality.least_volume = std::min(quality.least_volume, volume);
        quality.total_volume += volume;
        const double ratio = radius_ratio(x);
        quality.least_radius_ratio = std::min(quality.least_radius_ratio, ratio);
        quality.mean_radius_ratio += ratio / double(tetrahedra.rows());
        for (int a = 0; a < 4; ++a)
            for (int b = a + 1; b < 4; ++b) {
                // The angle between the two faces at edge ab: that of what is left of c and d across the edge.
                int others[2], n = 0;
                for (int c = 0; c < 4; ++c)
                    if (c != a && c != b) others[n++] = c;
                const Eigen::Vector3d axis = (x[b] - x[a]).normalized();
                const Eigen::Vector3d c = x[others[0]] - x[a], d = x[others[1]] - x[a];
                const Eigen::Vector3d across_c = c - axis * axis.dot(c), across_d = d - axis * axis.dot(d);
                const double angle = std::atan2(across_c.cross(across_d).norm(), across_c.dot(across_d));
                quality.least_dihedral = std::min(quality.least_dihedral, angle);
                quality.greatest_dihedral = std::max(quality.greatest_dihedral, angle);
            }
    }
    return quality;
}

}  // namespace ndg
