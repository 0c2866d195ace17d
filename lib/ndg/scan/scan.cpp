// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/split_edges.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/io/mesh.h"
#include "ndg/scan/scan_cut.h"
#include "ndg/scan/scan_normals.h"
#include "ndg/scan/scan_orientation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace ndg {
namespace {

constexpr std::array<double, 6> metres_per_unit = {1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048};
/// Largest extent of a standing adult, m: stature, span of the arms, or up to the tips of raised hands. The range
/// leaves every two of the units apart (their ratios are 2.54, 3.05, 3.28...; the range's own is 2.42).
constexpr double min_extent = 1.2, max_extent = 2.9;
/// With a given unit, sizes that are no person at all, m.
constexpr double least_extent = 0.4, greatest_extent = 4.0;
constexpr std::size_t min_points = 500;
/// In any unit. Triangles that reach farther would be split into more pieces than a machine holds.
constexpr double largest_coordinate = 1e7;
/// Edges of a mesh are split until they are shorter than this share of its size: before floor and stray parts are
/// looked for, and for the points that are registered (10 mm for a person of 1.75 m).
constexpr double coarse_edge = 0.02, fine_edge = 0.006;
/// An axis this much shorter than the longest one is not up (share of the longest).
constexpr double min_up_share = 2.0 / 3.0;
/// Points whose best plane gives the normal: at 5 mm spacing a patch of about 3 cm.
constexpr int normal_neighbours = 24;

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

/// The rows whose flag is set.
void keep_rows(Points& points, const std::vector<char>& keep)
{
    Eigen::Index count = 0;
    for (std::size_t i = 0; i < keep.size(); ++i) {
        if (keep[i]) points.row(count++) = points.row(static_cast<Eigen::Index>(i));
    }
    points.conservativeResize(count, 3);
}

/// Triangles all of whose corners are kept; the vertices stay.
void keep_triangles(Triangles& triangles, const std::vector<char>& keep)
{
    Eigen::Index count = 0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        if (keep[triangles(t, 0)] && keep[triangles(t, 1)] && keep[triangles(t, 2)]) {
            triangles.row(count++) = triangles.row(t);
        }
    }
    triangles.conservativeResize(count, 3);
}

/// Only the vertices that triangles use.
void drop_unused_vertices(Points& vertices, Triangles& triangles)
{
    std::vector<int> new_of_old(vertices.rows(), -1);
    for (Eigen::Index i = 0; i < triangles.size(); ++i) new_of_old[triangles.data()[i]] = 0;
    int count = 0;
    for (std::size_t v = 0; v < new_of_old.size(); ++v) {
        if (new_of_old[v] < 0) continue;
        vertices.row(count) = vertices.row(static_cast<Eigen::Index>(v));
        new_of_old[v] = count++;
    }
    vertices.conservativeResize(count, 3);
    for (Eigen::Index i = 0; i < triangles.size(); ++i) triangles.data()[i] = new_of_old[triangles.data()[i]];
}

/// Edges longer than a share of the scan's size split: a large triangle is surface too.
void sample_triangles(Points& vertices, Triangles& triangles, double share)
{
    RowMatrix attributes = vertices;
    split_long_edges(attributes, triangles, share * robust_extents(vertices).maxCoeff());
    vertices = attributes;
}

/// Takes floor and stray parts away, in the file's unit, and says so. Returns the floor.
std::optional<ScanFloor> cut_away(Points& points, Triangles& triangles, bool is_cloud, std::vector<std::string>& notes)
{
    const auto cut = [&](const std::vector<char>& keep) {
        if (is_cloud) {
            keep_rows(points, keep);
        } else {
            keep_triangles(triangles, keep);
            drop_unused_vertices(points, triangles);
        }
    };
    const std::optional<ScanFloor> floor = find_floor(points);
    if (floor) {
        cut(points_above_floor(points, *floor));
        notes.push_back("a floor under the feet was cut away");
        if (points.rows() == 0) return floor;
    }
    const std::vector<char> person = points_of_person(points);
    const auto stray = std::count(person.begin(), person.end(), 0);
    if (stray > 0) {
        notes.push_back(fmt::format("stray parts with {:.1f} % of the points were cut away",
                                    100.0 * static_cast<double>(stray) / static_cast<double>(points.rows())));
        cut(person);
    }
    return floor;
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

/// Normals of the vertices of a mesh, outward part by part.
Points outward_normals(Points& vertices, Triangles& triangles, std::vector<std::string>& notes)
{
    const std::vector<int> triangle_parts = join_parts(vertices, triangles);
    drop_unused_vertices(vertices, triangles);
    std::vector<int> parts(vertices.rows(), 0);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) parts[triangles(t, k)] = triangle_parts[t];
    }
    Points normals = vertex_normals(vertices, triangles);
    const double spacing = std::sqrt(triangle_areas(vertices, triangles).sum() / static_cast<double>(vertices.rows()));
    const int turned = turn_outwards(vertices, spacing, parts, normals);
    const auto num_parts =
        triangle_parts.empty() ? 0 : *std::max_element(triangle_parts.begin(), triangle_parts.end()) + 1;
    if (turned > 0) notes.push_back(fmt::format("{} of {} parts were wound inside out and turned", turned, num_parts));
    return normals;
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
    require_input(scan.file_points >= min_points, "{}: has {} points, fewer than {}", name, scan.file_points,
                  min_points);
    require_input(vertices.cwiseAbs().maxCoeff() <= largest_coordinate,
                  "{}: holds a coordinate of {:g}, which is no place on a person in any unit", name,
                  vertices.cwiseAbs().maxCoeff());
    Triangles mesh = triangles;
    if (!scan.is_cloud) {
        join_parts(scan.points, mesh);
        drop_unused_vertices(scan.points, mesh);
        require_input(mesh.rows() > 0, "{}: none of its {} triangles has an area", name, triangles.rows());
        sample_triangles(scan.points, mesh, coarse_edge);
    }
    const std::optional<ScanFloor> floor = cut_away(scan.points, mesh, scan.is_cloud, scan.notes);
    require_input(scan.points.rows() >= static_cast<Eigen::Index>(min_points), "{}: has {} points, fewer than {}", name,
                  scan.points.rows(), min_points);
    if (!scan.is_cloud) {
        sample_triangles(scan.points, mesh, fine_edge);
        scan.normals = outward_normals(scan.points, mesh, scan.notes);
    }
    const Eigen::Vector3d extents = robust_extents(scan.points);
    choose_unit(name, options, extents.maxCoeff(), scan);
    scan.points *= scan.metres_per_unit;
    scan.up_axes = options.up ? std::vector<Axis>{*options.up} : possible_up_axes(extents);
    if (floor) {
        Eigen::Index axis = 0;
        floor->normal.cwiseAbs().maxCoeff(&axis);
        if (!options.up) scan.up_axes = {axis_along(static_cast<int>(axis), floor->normal[axis] < 0)};
        scan.floor =
            Eigen::Vector4d(floor->normal[0], floor->normal[1], floor->normal[2], floor->offset * scan.metres_per_unit);
    }

    if (scan.points.rows() > options.max_points) {
        thin_out(scan.points, scan.normals, options.max_points);
        log_info("{}: {} points thinned to {}", name, scan.file_points, scan.points.rows());
    }
    require_input(scan.points.rows() >= static_cast<Eigen::Index>(min_points),
                  "{}: has {} distinct points, fewer than {}", name, scan.points.rows(), min_points);
    const PointTree tree(scan.points);
    scan.spacing = median_spacing(scan.points, tree);
    scan.normals = estimate_normals(scan.points, tree, normal_neighbours, scan.normals);
    return scan;
}

ScanPoints read_scan(const std::string& path, const ScanOptions& options)
{
    MeshReading reading;
    reading.drop_invalid = true;
    const MeshFile file = read_mesh(path, reading);
    if (file.num_dropped > 0)
        log_warning("{}: {} of {} points are no numbers and are left out", path, file.num_dropped,
                    file.num_dropped + file.vertices.rows());
    return prepare_scan(path, file.vertices, file.triangles, options);
}

}  // namespace ndg
