// SPDX-License-Identifier: Apache-2.0
// Where on a wrap a point lies, found from where it lay before.
#pragma once

#include "ndg/bones/surface_spread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <experimental/simd>
#include <vector>

namespace ndg {

/// Which triangles of a surface lie beside which.
struct SurfaceNeighbours {
    SurfaceNeighbours(const Eigen::Ref<const Triangles>& triangles, int num_vertices);

    Triangles triangles;
    std::vector<std::array<int, 3>> beside;      ///< of each triangle, across the edge opposite to a corner; -1: none
    std::vector<std::vector<int>> triangles_of;  ///< of each vertex
};

/// Where on the wrap a point lies.
struct WrapFoot {
    int triangle = -1;
    float height = 0.0F;                                 ///< of the point (m), negative inside
    Eigen::Vector3f outwards = Eigen::Vector3f::Zero();  ///< of length 1, along the line to the point
    Eigen::Vector3f barycentric = Eigen::Vector3f::Zero();
};

/// Eight points side by side in a vector register.
using LanesF = std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, 8>>;

[[gnu::always_inline]] inline LanesF load_lanes(const float* values)
{
    return LanesF(values, std::experimental::element_aligned);
}
[[gnu::always_inline]] inline void store_lanes(const LanesF& lanes, float* values)
{
    lanes.copy_to(values, std::experimental::element_aligned);
}
/// x, y, z of the vertices `vertex(lane)`.
template <typename Vertex>
[[gnu::always_inline]] inline std::array<LanesF, 3> vertex_lanes(const PointColumnsF& vertices, const Vertex& vertex)
{
    std::array<const float*, LanesF::size()> columns;
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = vertices.data() + 4 * std::ptrdiff_t(vertex(i));
    const auto lanes = [&](int axis) { return LanesF([&](auto i) { return columns[i][axis]; }); };
    return {lanes(0), lanes(1), lanes(2)};
}

// One number, or one a lane. Products stand in the order in which the compiler then fuses them with the sums that they
// are part of, the same for both, so that a point is over a triangle for one of them where it is for the other.
template <typename Real>
std::array<Real, 3> difference(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <typename Real>
Real dot(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
    const Real x = a[0] * b[0], z = a[2] * b[2], y = a[1] * b[1];
    return x + (z + y);
}
template <typename Real>
std::array<Real, 3> cross(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
    const auto minor = [&](std::size_t i, std::size_t j) -> Real {
        const Real ij = a[i] * b[j], ji = a[j] * b[i];
        return ij - ji;
    };
    return {minor(1, 2), minor(2, 0), minor(0, 1)};
}

/// A triangle (a, a + u, a + v) seen from a point: one, or one a lane.
template <typename Real>
struct SeenTriangle {
    using Vector = std::array<Real, 3>;
    Vector normal;              ///< not of length 1
    Real area;                  ///< length of the normal, squared
    Real first, second, third;  ///< barycentric coordinates times `area`
    Real length;                ///< of the normal
    Real height;                ///< of the point

    SeenTriangle(const Vector& a, const Vector& b, const Vector& c, const Vector& point)
    {
        using std::max, std::sqrt;
        const Vector u = difference(b, a), v = difference(c, a), d = difference(point, a);
        normal = cross(u, v);
        area = dot(normal, normal);
        const Vector across = cross(normal, d);
        second = dot(across, v);
        third = -dot(across, u);
        first = area - second - third;
        length = sqrt(max(area, Real(1e-30F)));
        height = dot(d, normal) / length;
    }
    Real least() const
    {
        using std::min;
        return min(first, min(second, third));
    }
};

/// Points near a wrap, each axis and each quantity apart, so that vector instructions look at several of them at once.
struct FollowedPoints {
    std::array<std::vector<float>, 3> axes;  ///< x, y, z
    std::vector<float> allowed;              ///< height of each over the wrap (m)
    std::vector<int> triangles;              ///< where each lies, or lay when last looked at
    std::vector<float> heights;              ///< of each over its triangle (m), negative inside
    std::vector<WrapFoot> feet;              ///< of those that are higher than allowed; of others they may be old

    int size() const { return size_; }
    /// Room is kept, what is in it is not cleared.
    void resize(int count);
    /// Overwrites a point by another one.
    void copy(int from, int to);

private:
    int size_ = 0;
};

/// Goes over the wrap (4 x N) from triangle to triangle to one under or over each of the points begin .. end - 1: a
/// bone that slides under the wrap is followed, and another fold of the wrap that touches this one is not taken for it.
/// Where a point lies over an edge and may be higher than allowed, the nearest place is looked for. Points over
/// triangles of which no corner v has `moved[v]` stay as they are.
void follow(const SurfaceNeighbours& surface, const PointColumnsF& wrap, const std::vector<char>& moved, int begin,
            int end, FollowedPoints& points);

}  // namespace ndg
