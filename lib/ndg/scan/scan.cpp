// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/io/mesh.h"
#include "ndg/scan/scan_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace ndg {
namespace {

constexpr std::array<double, 6> metres_per_unit = {1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048};
/// Largest extent of a standing adult, m: stature, or span of the arms. Adults of 1.2 to 2.35 m leave every two of the
/// units apart (their ratios are 2.54, 3.05, 3.28...; the range's own is 1.96).
constexpr double min_extent = 1.2, max_extent = 2.35;
/// With a given unit, sizes that are no person at all, m.
constexpr double least_extent = 0.4, greatest_extent = 4.0;
constexpr Eigen::Index min_points = 500;
/// An axis this much shorter than the longest one is not up (share of the longest).
constexpr double min_up_share = 2.0 / 3.0;
/// Points whose best plane gives the normal: at 5 mm spacing a patch of about 3 cm.
constexpr int normal_neighbours = 24;

/// Extents between the 0.1 and 99.9 percentiles along the axes: a few stray points do not matter.
Eigen::Vector3d robust_extents(const Points& points)
{
    Eigen::Vector3d extents;
    std::vector<double> values(points.rows());
    const auto rank = static_cast<std::ptrdiff_t>(values.size() / 1000);
    for (int k = 0; k < 3; ++k) {
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = points(static_cast<Eigen::Index>(i), k);
        const auto low = values.begin() + rank, high = values.end() - 1 - rank;
        std::nth_element(values.begin(), low, values.end());
        const double lowest = *low;
        std::nth_element(values.begin(), high, values.end());
        extents[k] = *high - lowest;
    }
    return extents;
}

/// Cell of each point of a grid: the same number for points of the same cell.
std::vector<std::pair<std::uint64_t, int>> sorted_cells(const Points& points, double spacing, Eigen::Index stride)
{
    const Eigen::RowVector3d low = points.colwise().minCoeff();
    std::vector<std::pair<std::uint64_t, int>> cells;
    cells.reserve(points.rows() / stride + 1);
    for (Eigen::Index i = 0; i < points.rows(); i += stride) {
        std::uint64_t key = 0;
        for (int k = 0; k < 3; ++k) {
            const double cell = std::min((points(i, k) - low[k]) / spacing, 2097151.0);
            key = (key << 21) | static_cast<std::uint64_t>(cell);
        }
        cells.emplace_back(key, static_cast<int>(i));
    }
    std::sort(cells.begin(), cells.end());
    return cells;
}

/// Replaces the points of each cell of a grid by their mean, the grid such that about `max_points` are left.
void thin_out(Points& points, Points& normals, int max_points)
{
    const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / (10 * static_cast<Eigen::Index>(max_points)));
    const auto count_cells = [&](double spacing) {
        const auto cells = sorted_cells(points, spacing, stride);
        int count = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) count += i == 0 || cells[i].first != cells[i - 1].first;
        return count;
    };
    double spacing = 0.001;
    while (count_cells(spacing) > max_points) spacing *= 1.15;
    const auto cells = sorted_cells(points, spacing, 1);
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (i == 0 || cells[i].first != cells[i - 1].first) begins.push_back(i);
    }
    begins.push_back(cells.size());
    const auto count = static_cast<Eigen::Index>(begins.size()) - 1;
    const bool has_normals = normals.rows() == points.rows();
    Points kept = Points::Zero(count, 3), kept_normals = Points::Zero(has_normals ? count : 0, 3);
    for (Eigen::Index c = 0; c < count; ++c) {
        const std::size_t begin = begins[c], end = begins[static_cast<std::size_t>(c) + 1];
        for (std::size_t i = begin; i < end; ++i) {
            kept.row(c) += points.row(cells[i].second) / static_cast<double>(end - begin);
            if (has_normals) kept_normals.row(c) += normals.row(cells[i].second);
        }
    }
    points = std::move(kept);
    normals = std::move(kept_normals);
}

void keep_rows(Points& points, const std::vector<char>& keep)
{
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        if (keep[i]) points.row(count++) = points.row(i);
    }
    points.conservativeResize(count, 3);
}

void choose_unit(const std::string& name, const ScanOptions& options, double extent, ScanPoints& scan)
{
    scan.unit_guessed = !options.unit;
    std::optional<LengthUnit> found = options.unit;
    for (const auto& [unit, unused] : enum_table<LengthUnit>) {
        const double metres = extent * metres_of_unit(unit);
        if (scan.unit_guessed && metres >= min_extent && metres <= max_extent) found = unit;
    }
    require_input(found.has_value(),
                  "{}: its largest extent, {:.4g}, is that of a standing adult ({} to {} m) in no unit known; give the "
                  "unit if the scan is right",
                  name, extent, min_extent, max_extent);
    scan.unit = *found;
    scan.metres_per_unit = metres_of_unit(*found);
    const double metres = extent * scan.metres_per_unit;
    require_input(metres >= least_extent && metres <= greatest_extent,
                  "{}: its largest extent is {:.4g} m in unit {}, which is no person", name, metres,
                  to_name(scan.unit));
}

std::vector<Axis> possible_up_axes(const Eigen::Vector3d& extents)
{
    // Equal lengths: y before z before x, as files have it.
    std::vector<int> axes = {1, 2, 0};
    std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return extents[a] > extents[b]; });
    std::vector<Axis> result;
    for (const int axis : axes) {
        if (extents[axis] < min_up_share * extents.maxCoeff()) continue;
        result.insert(result.end(), {axis_along(axis, false), axis_along(axis, true)});
    }
    return result;
}

double median_spacing(const Points& points, const PointTree& tree)
{
    std::vector<double> distances;
    const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / 2000);
    for (Eigen::Index i = 0; i < points.rows(); i += stride) {
        distances.push_back(tree.nearest(points.row(i).transpose(), 2).back().squared_distance);
    }
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return std::sqrt(*middle);
}

}  // namespace

double metres_of_unit(LengthUnit unit)
{
    return metres_per_unit[static_cast<std::size_t>(unit)];
}

void describe(OptionList& list, ScanOptions& options)
{
    list.add("unit", options.unit, "unit of the scans");
    list.add("up", options.up, "axis of the scans that points up");
    list.add("max-points", options.max_points, "scans with more points are thinned to about that many", 2000, 1000000);
}

Eigen::Matrix3d rotation_to_y_up(Axis up)
{
    if (up == Axis::minus_y) return about_x(EIGEN_PI);
    return minimal_rotation(unit_vector(up), Eigen::Vector3d::UnitY());
}

ScanPoints prepare_scan(const std::string& name, const Eigen::Ref<const Points>& vertices,
                        const Eigen::Ref<const Triangles>& triangles, const ScanOptions& options)
{
    check_options(options);
    ScanPoints scan;
    scan.points = vertices;
    scan.file_points = static_cast<std::size_t>(vertices.rows());
    scan.is_cloud = triangles.rows() == 0;
    require_input(vertices.allFinite(), "{}: holds a vertex that is not finite", name);
    if (!scan.is_cloud) {
        scan.normals = vertex_normals(vertices, triangles);
        if (enclosed_volume(vertices.rowwise() - vertices.colwise().mean(), triangles) < 0) scan.normals *= -1.0;
        std::vector<char> used(vertices.rows(), 0);
        for (Eigen::Index t = 0; t < triangles.size(); ++t) used[triangles.data()[t]] = 1;
        keep_rows(scan.points, used);
        keep_rows(scan.normals, used);
    }
    require_input(scan.points.rows() >= min_points, "{}: has {} points, fewer than {}", name, scan.points.rows(),
                  min_points);
    const Eigen::Vector3d extents = robust_extents(scan.points);
    choose_unit(name, options, extents.maxCoeff(), scan);
    scan.points *= scan.metres_per_unit;
    scan.up_axes = options.up ? std::vector<Axis>{*options.up} : possible_up_axes(extents);

    if (scan.points.rows() > options.max_points) {
        thin_out(scan.points, scan.normals, options.max_points);
        log_info("{}: {} points thinned to {}", name, scan.file_points, scan.points.rows());
    }
    require_input(scan.points.rows() >= min_points, "{}: has {} distinct points, fewer than {}", name,
                  scan.points.rows(), min_points);
    const PointTree tree(scan.points);
    scan.spacing = median_spacing(scan.points, tree);
    scan.normals = estimate_normals(scan.points, tree, normal_neighbours, scan.normals);
    return scan;
}

ScanPoints read_scan(const std::string& path, const ScanOptions& options)
{
    const MeshFile file = read_mesh(path);
    return prepare_scan(path, file.vertices, file.triangles, options);
}

}  // namespace ndg
