// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan_orientation.h"

#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

namespace ndg {
namespace {

/// Cells across the scan's longest side: 12 mm for a person, so that both sides of a wrist lie in different ones. Where
/// points are sparser the cells are larger, or rays would pass between them.
constexpr int grid_cells = 150;
constexpr double cells_per_spacing = 1.2;
constexpr std::size_t part_samples = 240;
constexpr int num_rays = 24;
/// Where a ray starts off the surface, cells.
constexpr double first_step = 2.0;

/// Which cells of a grid hold points.
class Occupancy {
public:
    Occupancy(const Eigen::Ref<const Points>& points, double spacing)
    {
        low_ = points.colwise().minCoeff().transpose();
        const Eigen::Vector3d extent = points.colwise().maxCoeff().transpose() - low_;
        cell_ =
            std::max({extent.maxCoeff() / grid_cells, cells_per_spacing * spacing, std::numeric_limits<double>::min()});
        for (int k = 0; k < 3; ++k) size_[k] = static_cast<int>(extent[k] / cell_) + 1;
        occupied_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], 0);
        for (Eigen::Index i = 0; i < points.rows(); ++i) {
            occupied_[index(((points.row(i).transpose() - low_) / cell_).array().floor().cast<int>())] = 1;
        }
    }
    double cell() const { return cell_; }
    /// Whether a ray leaves the grid without meeting an occupied cell.
    bool escapes(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const
    {
        for (Eigen::Vector3d place = (origin - low_) / cell_;; place += 0.7 * direction) {
            const Eigen::Vector3i at = place.array().floor().cast<int>();
            if ((at.array() < 0).any() || (at.array() >= size_.array()).any()) return true;
            if (occupied_[index(at)]) return false;
        }
    }

private:
    std::size_t index(const Eigen::Vector3i& at) const
    {
        return (static_cast<std::size_t>(at[2]) * size_[1] + at[1]) * size_[0] + at[0];
    }
    Eigen::Vector3d low_;
    Eigen::Vector3i size_;
    double cell_;
    std::vector<char> occupied_;
};

/// Directions of a hemisphere about a normal, denser near it.
Eigen::Vector3d ray_direction(const Eigen::Vector3d& normal, int ray)
{
    const double height = std::sqrt(1.0 - (ray + 0.5) / num_rays * 0.9), radius = std::sqrt(1.0 - height * height);
    const double angle = ray * EIGEN_PI * (3.0 - std::sqrt(5.0));
    const Eigen::Vector3d across = normal.unitOrthogonal();
    return height * normal + radius * (std::cos(angle) * across + std::sin(angle) * normal.cross(across));
}

}  // namespace

std::vector<int> join_parts(Points& vertices, Triangles& triangles)
{
    std::vector<int> order(vertices.rows()), joined(vertices.rows());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int v) { return std::make_tuple(vertices(v, 0), vertices(v, 1), vertices(v, 2)); };
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return std::make_pair(key(a), a) < std::make_pair(key(b), b); });
    for (std::size_t i = 0; i < order.size(); ++i) {
        joined[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? joined[order[i - 1]] : order[i];
    }
    Eigen::Index count = 0;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Eigen::RowVector3i corners(joined[triangles(t, 0)], joined[triangles(t, 1)], joined[triangles(t, 2)]);
        const Eigen::RowVector3d a = vertices.row(corners[0]), b = vertices.row(corners[1]);
        if ((b - a).cross(vertices.row(corners[2]) - a).squaredNorm() > 0) triangles.row(count++) = corners;
    }
    triangles.conservativeResize(count, 3);

    // Triangles at each edge; an edge of more than two joins nothing.
    std::vector<std::array<int, 3>> edges;  // low vertex, high vertex, 3 triangle + corner
    for (int t = 0; t < count; ++t) {
        for (int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(triangles(t, k), triangles(t, (k + 1) % 3));
            edges.push_back({low, high, 3 * t + k});
        }
    }
    std::sort(edges.begin(), edges.end());
    std::vector<int> across(3 * count, -1);
    for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
        while (end < edges.size() && edges[end][0] == edges[i][0] && edges[end][1] == edges[i][1]) ++end;
        if (end - i != 2) continue;
        across[edges[i][2]] = edges[i + 1][2];
        across[edges[i + 1][2]] = edges[i][2];
    }
    const Triangles given = triangles;
    std::vector<int> parts(count, -1);
    std::vector<char> turned(count, 0);
    int num_parts = 0;
    for (int seed = 0; seed < count; ++seed) {
        if (parts[seed] >= 0) continue;
        std::vector<int> open = {seed};
        parts[seed] = num_parts;
        while (!open.empty()) {
            const int t = open.back();
            open.pop_back();
            for (int k = 0; k < 3; ++k) {
                const int other_edge = across[3 * t + k];
                if (other_edge < 0 || parts[other_edge / 3] >= 0) continue;
                const int other = other_edge / 3;
                // Neighbours agree where their common edge runs in opposite directions.
                const bool same = given(t, k) == given(other, other_edge % 3);
                turned[other] = static_cast<char>(turned[t] != static_cast<char>(same));
                parts[other] = num_parts;
                open.push_back(other);
            }
        }
        ++num_parts;
    }
    for (int t = 0; t < count; ++t) {
        if (turned[t]) std::swap(triangles(t, 1), triangles(t, 2));
    }
    return parts;
}

int turn_outwards(const Eigen::Ref<const Points>& points, double spacing, const std::vector<int>& parts,
                  Points& normals)
{
    if (points.rows() == 0) return 0;
    const Occupancy occupancy(points, spacing);
    std::map<int, std::vector<int>> rows_of_part;
    for (std::size_t i = 0; i < parts.size(); ++i) rows_of_part[parts[i]].push_back(static_cast<int>(i));
    int num_turned = 0;
    for (const auto& [part, rows] : rows_of_part) {
        const std::size_t stride = std::max<std::size_t>(1, rows.size() / part_samples);
        int balance = 0;
        for (std::size_t i = 0; i < rows.size(); i += stride) {
            const Eigen::Vector3d normal = normals.row(rows[i]).transpose();
            if (normal.squaredNorm() < 0.5) continue;
            for (const double side : {1.0, -1.0}) {
                const Eigen::Vector3d outward = side * normal;
                const Eigen::Vector3d start = points.row(rows[i]).transpose() + first_step * occupancy.cell() * outward;
                for (int ray = 0; ray < num_rays; ++ray) {
                    if (occupancy.escapes(start, ray_direction(outward, ray))) balance += side > 0 ? 1 : -1;
                }
            }
        }
        if (balance >= 0) continue;
        ++num_turned;
        for (const int row : rows) normals.row(row) *= -1.0;
    }
    return num_turned;
}

}  // namespace ndg
