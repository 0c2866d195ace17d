// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan_cut.h"

#include "ndg/geometry/point_tree.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace ndg {
namespace {

// All lengths as shares of the scan's largest extent, areas of its square.
constexpr double near_plane = 0.005;     ///< 9 mm for a person of 1.75 m
constexpr double area_cell = 0.03;       ///< squares by which a plane's area is counted
constexpr double min_floor_area = 0.05;  ///< both soles of a person have 0.012 to 0.016
constexpr double part_cell = 0.03;
constexpr int plane_samples = 20000, plane_candidates = 300, plane_neighbours = 40;
/// Share of what is not floor that lies above it.
constexpr double min_above = 0.97;

struct Plane {
    Eigen::Vector3d normal;
    double offset;
};

Plane fit_plane(const Points& points, const std::vector<int>& rows)
{
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (const int row : rows) centre += points.row(row) / static_cast<double>(rows.size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const int row : rows) {
        const Eigen::RowVector3d offset = points.row(row) - centre;
        covariance += offset.transpose() * offset;
    }
    const Eigen::Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(0);
    return {normal, centre.dot(normal)};
}

std::vector<int> rows_near(const Points& points, const Plane& plane, double distance)
{
    std::vector<int> rows;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        if (std::abs(points.row(i).dot(plane.normal) - plane.offset) < distance) rows.push_back(static_cast<int>(i));
    }
    return rows;
}

/// Squares of the plane that hold a point.
std::size_t count_cells(const Points& points, const std::vector<int>& rows, const Plane& plane, double cell)
{
    const Eigen::Vector3d across = plane.normal.unitOrthogonal(), along = plane.normal.cross(across);
    std::set<std::pair<std::int64_t, std::int64_t>> cells;
    for (const int row : rows) {
        cells.emplace(std::llround(points.row(row).dot(across) / cell),
                      std::llround(points.row(row).dot(along) / cell));
    }
    return cells.size();
}

}  // namespace

Eigen::Vector3d robust_extents(const Eigen::Ref<const Points>& points)
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

std::optional<ScanFloor> find_floor(const Eigen::Ref<const Points>& points)
{
    const double size = robust_extents(points).maxCoeff();
    if (!(size > 0)) return std::nullopt;
    const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / plane_samples);
    Points sample((points.rows() + stride - 1) / stride, 3);
    for (Eigen::Index i = 0; i < sample.rows(); ++i) sample.row(i) = points.row(i * stride);

    const PointTree tree(sample);
    const Eigen::Index candidate_stride = std::max<Eigen::Index>(1, sample.rows() / plane_candidates);
    Plane best{};
    std::size_t most = 0;
    for (Eigen::Index i = 0; i < sample.rows(); i += candidate_stride) {
        std::vector<int> patch;
        for (const PointTree::Neighbour& neighbour : tree.nearest(sample.row(i).transpose(), plane_neighbours)) {
            patch.push_back(neighbour.idx);
        }
        Plane plane = fit_plane(sample, patch);
        std::vector<int> rows = rows_near(sample, plane, near_plane * size);
        if (rows.size() < 3) continue;
        plane = fit_plane(sample, rows);
        rows = rows_near(sample, plane, near_plane * size);
        const std::size_t cells = count_cells(sample, rows, plane, area_cell * size);
        if (cells <= most) continue;
        most = cells;
        best = plane;
    }
    ScanFloor floor;
    floor.area = static_cast<double>(most) * std::pow(area_cell * size, 2);
    if (floor.area < min_floor_area * size * size) return std::nullopt;

    std::vector<double> heights;
    for (Eigen::Index i = 0; i < sample.rows(); ++i) {
        const double height = sample.row(i).dot(best.normal) - best.offset;
        if (std::abs(height) > near_plane * size) heights.push_back(height);
    }
    if (heights.empty()) return std::nullopt;
    std::sort(heights.begin(), heights.end());
    const auto below = std::lower_bound(heights.begin(), heights.end(), 0.0) - heights.begin();
    const double above = 1.0 - static_cast<double>(below) / static_cast<double>(heights.size());
    const bool turned = above < 0.5;
    if (std::max(above, 1.0 - above) < min_above) return std::nullopt;
    floor.normal = turned ? Eigen::Vector3d(-best.normal) : best.normal;
    floor.offset = turned ? -best.offset : best.offset;

    // A person's back or a wall behind it is no floor: what stands on a floor is high.
    Points rest(static_cast<Eigen::Index>(heights.size()), 3);
    Eigen::Index count = 0;
    const Eigen::Vector3d across = floor.normal.unitOrthogonal(), along = floor.normal.cross(across);
    for (Eigen::Index i = 0; i < sample.rows(); ++i) {
        const double height = sample.row(i).dot(floor.normal) - floor.offset;
        if (std::abs(height) <= near_plane * size) continue;
        rest.row(count++) << sample.row(i).dot(across), sample.row(i).dot(along), height;
    }
    const Eigen::Vector3d extents = robust_extents(rest);
    if (extents[2] < 0.5 * extents.maxCoeff()) return std::nullopt;
    return floor;
}

std::vector<char> points_above_floor(const Eigen::Ref<const Points>& points, const ScanFloor& floor)
{
    const double margin = near_plane * robust_extents(points).maxCoeff();
    std::vector<char> above(points.rows());
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        above[i] = points.row(i).dot(floor.normal) - floor.offset > margin;
    }
    return above;
}

std::vector<char> points_of_person(const Eigen::Ref<const Points>& points, double min_share)
{
    const double cell = part_cell * robust_extents(points).maxCoeff();
    using Cell = std::array<std::int64_t, 3>;
    std::map<Cell, int> index_of_cell;
    std::vector<int> cell_of_point(points.rows());
    std::vector<std::size_t> sizes;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        Cell key{};
        for (int k = 0; k < 3; ++k) key[static_cast<std::size_t>(k)] = std::llround(std::floor(points(i, k) / cell));
        const auto [entry, added] = index_of_cell.emplace(key, static_cast<int>(sizes.size()));
        if (added) sizes.push_back(0);
        cell_of_point[i] = entry->second;
        ++sizes[entry->second];
    }
    std::vector<int> root(sizes.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    for (const auto& [key, index] : index_of_cell) {
        for (int n = 0; n < 27; ++n) {
            const auto other = index_of_cell.find({key[0] + n % 3 - 1, key[1] + n / 3 % 3 - 1, key[2] + n / 9 - 1});
            if (other != index_of_cell.end()) root[find(other->second)] = find(index);
        }
    }
    std::vector<std::size_t> totals(sizes.size(), 0);
    for (std::size_t c = 0; c < sizes.size(); ++c) totals[find(static_cast<int>(c))] += sizes[c];
    const double least = min_share * static_cast<double>(*std::max_element(totals.begin(), totals.end()));
    std::vector<char> keep(points.rows());
    for (std::size_t i = 0; i < keep.size(); ++i) {
        keep[i] = static_cast<double>(totals[find(cell_of_point[i])]) >= least;
    }
    return keep;
}

}  // namespace ndg
