// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/obstacle.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace ndg {

namespace {

/// A mesh that grows.
class Builder {
public:
    int add(const Eigen::Vector3d& vertex)
    {
        vertices_.push_back(vertex);
        return static_cast<int>(vertices_.size()) - 1;
    }
    void add(int a, int b, int c) { triangles_.push_back({a, b, c}); }
    TriangleMesh take() const
    {
        TriangleMesh mesh{Points(vertices_.size(), 3), Triangles(triangles_.size(), 3)};
        for (int v = 0; v < int(vertices_.size()); ++v) mesh.vertices.row(v) = vertices_[v];
        for (int t = 0; t < int(triangles_.size()); ++t) mesh.triangles.row(t) = triangles_[t];
        return mesh;
    }

private:
    std::vector<Eigen::Vector3d> vertices_;
    std::vector<Eigen::RowVector3i> triangles_;
};

int pieces(double length, double edge)
{
    return std::max(1, static_cast<int>(std::ceil(length / edge - 1e-9)));
}

}  // namespace

TriangleMesh plane_shape(double size, double edge)
{
    const int n = pieces(size, edge);
    Builder mesh;
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) mesh.add({size * (double(j) / n - 0.5), 0, size * (double(i) / n - 0.5)});
    }
    const auto at = [&](int i, int j) { return i * (n + 1) + j; };
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            // Diagonals in turns, so that no direction is preferred.
            const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
            if ((i + j) % 2 == 0) {
                mesh.add(a, b, c);
                mesh.add(a, c, d);
            } else {
                mesh.add(a, b, d);
                mesh.add(b, c, d);
            }
        }
    }
    const int apex = mesh.add({0, -0.25 * size, 0});
    for (int k = 0; k < n; ++k) {
        mesh.add(at(0, k), at(0, k + 1), apex);
        mesh.add(at(n, k + 1), at(n, k), apex);
        mesh.add(at(k + 1, 0), at(k, 0), apex);
        mesh.add(at(k, n), at(k + 1, n), apex);
    }
    return mesh.take();
}

TriangleMesh sphere_shape(double radius, double edge)
{
    const double golden = 0.5 * (1 + std::sqrt(5.0));
    std::vector<Eigen::Vector3d> corners;
    for (const double s : {-1.0, 1.0}) {
        for (const double t : {-golden, golden}) {
            corners.emplace_back(0, s, t);
            corners.emplace_back(s, t, 0);
            corners.emplace_back(t, 0, s);
        }
    }
    // Neighbours are 2 apart.
    const auto neighbours = [&](int a, int b) { return std::abs((corners[a] - corners[b]).norm() - 2) < 1e-9; };
    constexpr double widest = 1.2;  // an icosahedron's edge, and what projection makes of its pieces, by the radius
    const int n = pieces(widest * radius, edge);
    Builder mesh;
    std::map<std::vector<std::pair<int, int>>, int> known;  // by weights of corners
    const auto vertex = [&](const std::array<int, 3>& face, const std::array<int, 3>& weights) {
        std::vector<std::pair<int, int>> key;
        Eigen::Vector3d point = Eigen::Vector3d::Zero();
        for (std::size_t a = 0; a < 3; ++a) {
            if (weights[a] > 0) key.emplace_back(face[a], weights[a]);
            point += weights[a] * corners[face[a]];
        }
        std::sort(key.begin(), key.end());
        const auto found = known.find(key);
        if (found != known.end()) return found->second;
        return known[key] = mesh.add(radius * point.normalized());
    };
    for (int a = 0; a < 12; ++a) {
        for (int b = a + 1; b < 12; ++b) {
            for (int c = b + 1; c < 12; ++c) {
                if (!neighbours(a, b) || !neighbours(b, c) || !neighbours(a, c)) continue;
                std::array<int, 3> face{a, b, c};
                if (corners[a].dot(corners[b].cross(corners[c])) < 0) std::swap(face[1], face[2]);
                for (int i = 0; i < n; ++i) {
                    for (int j = 0; i + j < n; ++j) {
                        const int k = n - i - j;
                        const int base = vertex(face, {k, i, j}), right = vertex(face, {k - 1, i + 1, j}),
                                  up = vertex(face, {k - 1, i, j + 1});
                        mesh.add(base, right, up);
                        if (k > 1) mesh.add(right, vertex(face, {k - 2, i + 1, j + 1}), up);
                    }
                }
            }
        }
    }
    return mesh.take();
}

TriangleMesh capsule_shape(double radius, double length, double edge)
{
    const int around = std::max(6, pieces(2 * M_PI * radius, edge)), along = pieces(length, edge);
    const int up = std::max(2, pieces(0.5 * M_PI * radius, edge));
    std::vector<std::pair<double, double>> rings;  // radius and height, from below
    for (int i = 1; i <= up; ++i) {
        const double angle = 0.5 * M_PI * i / up;
        rings.emplace_back(radius * std::sin(angle), -0.5 * length - radius * std::cos(angle));
    }
    for (int i = 1; i < along; ++i) rings.emplace_back(radius, length * (double(i) / along - 0.5));
    for (int i = 0; i < up; ++i) {
        const double angle = 0.5 * M_PI * i / up;
        rings.emplace_back(radius * std::cos(angle), 0.5 * length + radius * std::sin(angle));
    }
    Builder mesh;
    for (const auto& [r, y] : rings) {
        for (int k = 0; k < around; ++k) {
            const double angle = 2 * M_PI * k / around;
            mesh.add({r * std::sin(angle), y, r * std::cos(angle)});
        }
    }
    const int low = mesh.add({0, -0.5 * length - radius, 0}), high = mesh.add({0, 0.5 * length + radius, 0});
    const int last = static_cast<int>(rings.size()) - 1;
    const auto at = [&](int ring, int k) { return ring * around + k % around; };
    for (int k = 0; k < around; ++k) {
        mesh.add(low, at(0, k + 1), at(0, k));
        for (int ring = 0; ring < last; ++ring) {
            mesh.add(at(ring, k), at(ring, k + 1), at(ring + 1, k + 1));
            mesh.add(at(ring, k), at(ring + 1, k + 1), at(ring + 1, k));
        }
        mesh.add(at(last, k), at(last, k + 1), high);
    }
    return mesh.take();
}

TriangleMesh box_shape(const Eigen::Vector3d& size, double edge)
{
    const std::array<int, 3> n{pieces(size[0], edge), pieces(size[1], edge), pieces(size[2], edge)};
    Builder mesh;
    std::map<std::array<int, 3>, int> known;
    const auto vertex = [&](const std::array<int, 3>& place) {
        const auto found = known.find(place);
        if (found != known.end()) return found->second;
        Eigen::Vector3d point;
        for (std::size_t k = 0; k < 3; ++k) {
            point[static_cast<Eigen::Index>(k)] = size[static_cast<Eigen::Index>(k)] * (double(place[k]) / n[k] - 0.5);
        }
        return known[place] = mesh.add(point);
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t along = (axis + 1) % 3, across = (axis + 2) % 3;
        for (const bool high : {false, true}) {
            for (int i = 0; i < n[along]; ++i) {
                for (int j = 0; j < n[across]; ++j) {
                    const auto corner = [&](int di, int dj) {
                        std::array<int, 3> place{};
                        place[axis] = high ? n[axis] : 0;
                        place[along] = i + di;
                        place[across] = j + dj;
                        return vertex(place);
                    };
                    std::array<int, 4> square{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
                    if (!high) std::swap(square[1], square[3]);
                    // Diagonals in turns, as of planes.
                    const std::size_t k = (i + j) % 2 == 0 ? 0 : 1;
                    mesh.add(square[k], square[k + 1], square[(k + 2) % 4]);
                    mesh.add(square[k], square[(k + 2) % 4], square[(k + 3) % 4]);
                }
            }
        }
    }
    return mesh.take();
}

Eigen::Isometry3d Obstacle::world_from_obstacle(double time) const
{
    const auto pose = [](const Eigen::Vector3d& position, const Eigen::Quaterniond& rotation) {
        return Eigen::Isometry3d(Eigen::Translation3d(position) * rotation.normalized());
    };
    if (time <= keys.front().time) return pose(keys.front().position, keys.front().rotation);
    const auto next = std::find_if(keys.begin(), keys.end(), [&](const ObstacleKey& key) { return key.time > time; });
    if (next == keys.end()) {
        const ObstacleKey& last = keys.back();
        const double seconds = time - last.time;
        return pose(last.position + seconds * velocity,
                    Eigen::Quaterniond(rotation_of(seconds * angular_velocity)) * last.rotation);
    }
    const ObstacleKey& before = *(next - 1);
    const double share = (time - before.time) / (next->time - before.time);
    return pose(before.position + share * (next->position - before.position),
                before.rotation.slerp(share, next->rotation));
}

Points Obstacle::vertices(double time, const Eigen::Isometry3d& world_from_followed) const
{
    const Eigen::Isometry3d world_from_own = world_from_followed * world_from_obstacle(time);
    return (shape.vertices * world_from_own.linear().transpose()).rowwise() + world_from_own.translation().transpose();
}

ObstacleSolid solid_of(const TriangleMesh& shape, double mass_kg)
{
    // A cone of even density with its apex at the centre has the second moments of three fifths of its mass at its
    // base.
    constexpr double surface_share = 0.6;
    const Eigen::Index count = shape.vertices.rows();
    Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();
    double volume = 0;
    const auto corner = [&](Eigen::Index t, int a) -> Eigen::Vector3d {
        return shape.vertices.row(shape.triangles(t, a)).transpose();
    };
    for (Eigen::Index t = 0; t < shape.triangles.rows(); ++t) {
        const double part = corner(t, 0).dot(corner(t, 1).cross(corner(t, 2))) / 6;
        volume += part;
        first_moment += part * (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 4;
    }
    require(volume > 0, "a surface that encloses {} m^3 is no solid", volume);
    ObstacleSolid solid;
    solid.vertices.resize(count + 1, 3);
    solid.vertices.topRows(count) = shape.vertices;
    solid.vertices.row(count) = first_moment.transpose() / volume;
    solid.tetrahedra.resize(shape.triangles.rows(), 4);
    solid.masses.setZero(count + 1);
    for (Eigen::Index t = 0; t < shape.triangles.rows(); ++t) {
        solid.tetrahedra.row(t) << static_cast<int>(count), shape.triangles.row(t);
        const Eigen::Vector3d centre = solid.vertices.row(count);
        const double part = tetrahedron_volume(centre, corner(t, 0), corner(t, 1), corner(t, 2));
        require(part > 1e-9 * volume, "triangle {} cannot be seen from the centre of the volume it encloses", t);
        for (int a = 0; a < 3; ++a) {
            solid.masses[shape.triangles(t, a)] += surface_share * mass_kg * part / (3 * volume);
        }
    }
    solid.masses[count] = (1 - surface_share) * mass_kg;
    return solid;
}

}  // namespace ndg
