// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/closed_wrap.h"

#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace ndg {
namespace {

/// Point of a cap that all edges of its loop see from inside, as far as there is one: starting from the mean of the
/// loop it moves away from the nearest edge, in the loop's mean plane, by shorter and shorter steps.
Eigen::RowVector3d cap_centre(const Eigen::Ref<const Points>& vertices, const std::vector<int>& loop)
{
    constexpr int steps = 200;
    const std::size_t count = loop.size();
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero(), normal = Eigen::RowVector3d::Zero();
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::RowVector3d from = vertices.row(loop[i]), to = vertices.row(loop[(i + 1) % count]);
        centre += from / static_cast<double>(count);
        normal += from.cross(to);
    }
    if (normal.norm() == 0.0) return centre;
    normal.normalize();
    Eigen::RowVector3d best = centre;
    double best_room = -std::numeric_limits<double>::infinity(), radius = 0.0;
    for (const int v : loop) radius = std::max(radius, (vertices.row(v) - centre).norm());
    for (int step = 0; step < steps; ++step) {
        double room = std::numeric_limits<double>::infinity();
        Eigen::RowVector3d inward = Eigen::RowVector3d::Zero();
        for (std::size_t i = 0; i < count; ++i) {
            const Eigen::RowVector3d from = vertices.row(loop[i]), edge = vertices.row(loop[(i + 1) % count]) - from;
            const Eigen::RowVector3d side = normal.cross(edge).normalized();
            const double distance = (centre - from).dot(side);
            if (distance >= room) continue;
            room = distance;
            inward = side;
        }
        if (room > best_room) {
            best_room = room;
            best = centre;
        }
        centre += 0.3 * radius / (step + 1.0) * inward;
    }
    return best;
}

}  // namespace

ClosedBoneWrap close_bone_wrap(const Eigen::Ref<const Points>& bone_wrap,
                               const Eigen::Ref<const Triangles>& wrap_triangles)
{
    const int num_wrap = static_cast<int>(bone_wrap.rows());
    const auto loops = boundary_loops(wrap_triangles, num_wrap);
    ClosedBoneWrap closed;
    closed.vertices.resize(num_wrap + static_cast<Eigen::Index>(loops.size()), 3);
    closed.vertices.topRows(num_wrap) = bone_wrap;
    std::vector<Eigen::RowVector3i> caps;
    for (std::size_t l = 0; l < loops.size(); ++l) {
        const auto& loop = loops[l];
        const int centre = num_wrap + static_cast<int>(l);
        closed.vertices.row(centre) = cap_centre(bone_wrap, loop);
        for (std::size_t i = 0; i < loop.size(); ++i) {
            // The surface lies left of the loop, so the cap runs the other way round.
            caps.emplace_back(loop[(i + 1) % loop.size()], loop[i], centre);
        }
    }
    closed.triangles.resize(wrap_triangles.rows() + static_cast<Eigen::Index>(caps.size()), 3);
    closed.triangles.topRows(wrap_triangles.rows()) = wrap_triangles;
    for (std::size_t i = 0; i < caps.size(); ++i)
        closed.triangles.row(wrap_triangles.rows() + static_cast<Eigen::Index>(i)) = caps[i];
    return closed;
}

}  // namespace ndg
