// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/dynamic_mesh.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>

namespace ndg {

DynamicMesh::DynamicMesh(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& all_triangles,
                         const std::vector<int>& triangle_labels)
    : labels(triangle_labels), vertex_triangles(static_cast<std::size_t>(vertices.rows()))
{
    require(static_cast<Eigen::Index>(labels.size()) == all_triangles.rows(), "{} triangles but {} labels",
            all_triangles.rows(), labels.size());
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) positions.emplace_back(vertices.row(v).transpose());
    for (Eigen::Index t = 0; t < all_triangles.rows(); ++t) {
        triangles.push_back({all_triangles(t, 0), all_triangles(t, 1), all_triangles(t, 2)});
        for (const int v : triangles.back()) vertex_triangles[v].push_back(static_cast<int>(t));
    }
}

std::vector<std::array<int, 2>> DynamicMesh::edges() const
{
    std::vector<std::array<int, 2>> result;
    for (int t = 0; t < num_triangles(); ++t) {
        if (removed(t)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = triangle(t)[k], b = triangle(t)[(k + 1) % 3];
            if (a < b)
                result.push_back({a, b});
            else if (edge_triangles(b, a)[0] < 0)  // boundary edge that only runs downwards
                result.push_back({b, a});
        }
    }
    return result;
}

std::array<int, 2> DynamicMesh::edge_triangles(int a, int b) const
{
    std::array<int, 2> found{-1, -1};
    for (const int t : triangles_of(a)) {
        const auto& corners = triangle(t);
        for (std::size_t k = 0; k < 3; ++k) {
            if (corners[k] != a) continue;
            if (corners[(k + 1) % 3] == b) found[0] = t;
            if (corners[(k + 2) % 3] == b) found[1] = t;
        }
    }
    return found;
}

int DynamicMesh::opposite(int t, int a, int b) const
{
    for (const int v : triangle(t))
        if (v != a && v != b) return v;
    return -1;
}

bool DynamicMesh::is_feature(int a, int b) const
{
    const auto [left, right] = edge_triangles(a, b);
    return left < 0 || right < 0 || label(left) != label(right);
}

std::vector<int> DynamicMesh::neighbours(int v) const
{
    std::vector<int> result;
    for (const int t : triangles_of(v))
        for (const int other : triangle(t))
            if (other != v) result.push_back(other);
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

std::vector<int> DynamicMesh::feature_neighbours(int v) const
{
    std::vector<int> result = neighbours(v);
    result.erase(std::remove_if(result.begin(), result.end(), [&](int other) { return !is_feature(v, other); }),
                 result.end());
    return result;
}

void DynamicMesh::detach(int v, int t)
{
    auto& list = vertex_triangles[v];
    list.erase(std::remove(list.begin(), list.end(), t), list.end());
}

int DynamicMesh::split(int a, int b, const Eigen::Vector3d& position)
{
    const int middle = num_vertices();
    positions.push_back(position);
    vertex_triangles.emplace_back();
    for (const int t : edge_triangles(a, b)) {
        if (t < 0) continue;
        const int far = opposite(t, a, b);
        std::array<int, 3> half = triangle(t);
        // The old triangle keeps a, the new one gets b.
        std::replace(half.begin(), half.end(), a, middle);
        auto& old = triangles[t];
        std::replace(old.begin(), old.end(), b, middle);
        const int added = num_triangles();
        triangles.push_back(half);
        labels.push_back(label(t));
        detach(b, t);
        vertex_triangles[b].push_back(added);
        vertex_triangles[far].push_back(added);
        vertex_triangles[middle].push_back(t);
        vertex_triangles[middle].push_back(added);
    }
    return middle;
}

bool DynamicMesh::is_boundary(int a, int b) const
{
    const auto [left, right] = edge_triangles(a, b);
    return left < 0 || right < 0;
}

bool DynamicMesh::on_boundary(int v) const
{
    // Round an inner vertex there are as many triangles as edges, on the boundary one fewer.
    return triangles_of(v).size() != neighbours(v).size();
}

bool DynamicMesh::can_flip(int a, int b) const
{
    const auto [left, right] = edge_triangles(a, b);
    if (left < 0 || right < 0 || label(left) != label(right)) return false;
    const int c = opposite(left, a, b), d = opposite(right, a, b);
    const auto between = edge_triangles(c, d);
    return c != d && between[0] < 0 && between[1] < 0 && !(on_boundary(c) && on_boundary(d));
}

void DynamicMesh::flip(int a, int b)
{
    const auto [left, right] = edge_triangles(a, b);  // (a, b, c) and (b, a, d)
    const int c = opposite(left, a, b), d = opposite(right, a, b);
    triangles[left] = {a, d, c};
    triangles[right] = {d, b, c};
    detach(b, left);
    detach(a, right);
    vertex_triangles[d].push_back(left);
    vertex_triangles[c].push_back(right);
}

bool DynamicMesh::can_collapse(int removed_vertex, int kept) const
{
    const auto feature = feature_neighbours(removed_vertex);
    if (!feature.empty()) {
        if (feature.size() != 2) return false;
        if (feature[0] != kept && feature[1] != kept) return false;
        // Both edges must be of one feature: the same labels on either side.
        const auto sides = [&](int other) {
            const auto both = edge_triangles(removed_vertex, other);
            std::array<int, 2> result{both[0] < 0 ? -1 : label(both[0]), both[1] < 0 ? -1 : label(both[1])};
            std::sort(result.begin(), result.end());
            return result;
        };
        if (sides(feature[0]) != sides(feature[1])) return false;
    }
    const auto [left, right] = edge_triangles(removed_vertex, kept);
    const std::size_t shared = (left >= 0 ? 1u : 0u) + (right >= 0 ? 1u : 0u);
    const auto of_removed = neighbours(removed_vertex), of_kept = neighbours(kept);
    std::vector<int> common;
    std::set_intersection(of_removed.begin(), of_removed.end(), of_kept.begin(), of_kept.end(),
                          std::back_inserter(common));
    if (common.size() != shared) return false;
    if (on_boundary(kept)) {
        for (const int other : of_removed) {
            if (other == kept || std::binary_search(common.begin(), common.end(), other)) continue;
            if (on_boundary(other) && !is_boundary(removed_vertex, other)) return false;
        }
    }
    // Neither the surface nor a feature chain may close onto itself.
    for (const int t : {left, right})
        if (t >= 0 && triangles_of(opposite(t, removed_vertex, kept)).size() < 4 &&
            feature_neighbours(opposite(t, removed_vertex, kept)).empty())
            return false;
    if (!feature.empty()) {
        for (const int other : common)
            if (is_feature(removed_vertex, other)) return false;
    }
    return triangles_of(removed_vertex).size() > shared;
}

void DynamicMesh::collapse(int removed_vertex, int kept)
{
    for (const int t : std::vector<int>(triangles_of(removed_vertex))) {
        auto& corners = triangles[t];
        if (std::find(corners.begin(), corners.end(), kept) != corners.end()) {
            for (const int v : corners) detach(v, t);
            corners = {-1, -1, -1};
        } else {
            std::replace(corners.begin(), corners.end(), removed_vertex, kept);
            vertex_triangles[kept].push_back(t);
        }
    }
    vertex_triangles[removed_vertex].clear();
}

Eigen::Vector3d DynamicMesh::normal(int t) const
{
    const auto& [a, b, c] = triangle(t);
    const Eigen::Vector3d area = (position(b) - position(a)).cross(position(c) - position(a));
    const double length = area.norm();
    return length > 0.0 ? Eigen::Vector3d(area / length) : Eigen::Vector3d::Zero();
}

double DynamicMesh::min_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    // The smallest angle lies opposite the shortest side.
    const double area = (b - a).cross(c - a).norm();
    if (!(area > 0.0)) return 0.0;
    const double ab = (b - a).norm(), bc = (c - b).norm(), ca = (a - c).norm();
    if (ab <= bc && ab <= ca) return std::atan2(area, (a - c).dot(b - c));
    if (bc <= ab && bc <= ca) return std::atan2(area, (b - a).dot(c - a));
    return std::atan2(area, (a - b).dot(c - b));
}

void DynamicMesh::compact(Points& vertices, Triangles& remaining, std::vector<int>& remaining_labels,
                          std::vector<int>* old_of_new) const
{
    std::vector<int> new_of_old(positions.size(), -1), kept;
    for (int v = 0; v < num_vertices(); ++v) {
        if (triangles_of(v).empty()) continue;
        new_of_old[v] = static_cast<int>(kept.size());
        kept.push_back(v);
    }
    vertices.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t v = 0; v < kept.size(); ++v)
        vertices.row(static_cast<Eigen::Index>(v)) = position(kept[v]).transpose();
    std::vector<int> rows;
    for (int t = 0; t < num_triangles(); ++t)
        if (!removed(t)) rows.push_back(t);
    remaining.resize(static_cast<Eigen::Index>(rows.size()), 3);
    remaining_labels.clear();
    for (std::size_t row = 0; row < rows.size(); ++row) {
        for (int k = 0; k < 3; ++k) remaining(static_cast<Eigen::Index>(row), k) = new_of_old[triangle(rows[row])[k]];
        remaining_labels.push_back(label(rows[row]));
    }
    if (old_of_new != nullptr) *old_of_new = std::move(kept);
}

}  // namespace ndg
