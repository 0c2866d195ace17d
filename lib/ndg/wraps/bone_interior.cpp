// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/bone_interior.h"

#include "ndg/core/error.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/tetrahedralize.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

namespace ndg {

namespace {

/// Values at interior vertices that are harmonic (uniform graph Laplacian over the tetrahedra's edges) for the given
/// values at the wrap vertices. `wrap_values`: N_w x k. Returns N_i x k.
Eigen::MatrixXd harmonic_extension(const Eigen::Ref<const Tetrahedra>& tetrahedra, Eigen::Index num_wrap,
                                   Eigen::Index num_interior, const Eigen::Ref<const Eigen::MatrixXd>& wrap_values)
{
    if (num_interior == 0) return Eigen::MatrixXd(0, wrap_values.cols());
    std::set<std::pair<int, int>> edges;
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t)
        for (int a = 0; a < 4; ++a)
            for (int b = a + 1; b < 4; ++b) edges.insert(std::minmax(tetrahedra(t, a), tetrahedra(t, b)));
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(num_interior, wrap_values.cols());
    for (const auto& [a, b] : edges) {
        const Eigen::Index ia = a - num_wrap, ib = b - num_wrap;
        if (ia >= 0) entries.emplace_back(ia, ia, 1.0);
        if (ib >= 0) entries.emplace_back(ib, ib, 1.0);
        if (ia >= 0 && ib >= 0) {
            entries.emplace_back(ia, ib, -1.0);
            entries.emplace_back(ib, ia, -1.0);
        } else if (ia >= 0) {
            right.row(ia) += wrap_values.row(b);
        } else if (ib >= 0) {
            right.row(ib) += wrap_values.row(a);
        }
    }
    Eigen::SparseMatrix<double> laplacian(num_interior, num_interior);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky solver;
    solver.analyze(laplacian);
    if (!solver.factorize(laplacian))
        throw SolverError("bone interior: an interior vertex is not connected to the bone wrap");
    return solver.solve(right);
}

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

/// Throws Error with the place of the first two triangles of the closed wrap that run through each other.
void check_closed_wrap(const ClosedBoneWrap& closed, Eigen::Index num_wrap_triangles)
{
    const auto pairs = self_intersections(closed.vertices, closed.triangles, true);
    if (pairs.empty()) return;
    const auto kind = [&](int t) { return t < num_wrap_triangles ? "wrap" : "cap"; };
    const Eigen::RowVector3d place = closed.vertices.row(closed.triangles(pairs.front().first, 0));
    throw Error(
        fmt::format("the closed bone wrap runs through itself in {} places, the first near ({:.3f}, {:.3f}, "
                    "{:.3f}) ({} triangle {} and {} triangle {})",
                    pairs.size(), place.x(), place.y(), place.z(), kind(pairs.front().first), pairs.front().first,
                    kind(pairs.front().second), pairs.front().second));
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

BoneInterior fill_bone_wrap(const Eigen::Ref<const Points>& bone_wrap,
                            const Eigen::Ref<const Triangles>& wrap_triangles,
                            const Eigen::Ref<const RowMatrix>& wrap_weights)
{
    const int num_wrap = static_cast<int>(bone_wrap.rows());
    const ClosedBoneWrap closed = close_bone_wrap(bone_wrap, wrap_triangles);
    check_closed_wrap(closed, wrap_triangles.rows());
    TetrahedralMesh mesh = tetrahedralize(closed.vertices, closed.triangles);
    BoneInterior interior;
    interior.vertices = mesh.vertices.bottomRows(mesh.vertices.rows() - num_wrap);
    interior.tetrahedra = std::move(mesh.tetrahedra);
    interior.weights = harmonic_extension(interior.tetrahedra, num_wrap, interior.vertices.rows(), wrap_weights);
    return interior;
}

Points transfer_interior(const Eigen::Ref<const Points>& template_bone_wrap,
                         const Eigen::Ref<const Points>& template_interior,
                         const Eigen::Ref<const Tetrahedra>& tetrahedra, const Eigen::Ref<const Points>& bone_wrap)
{
    const Eigen::MatrixXd displacement = bone_wrap - template_bone_wrap;
    return template_interior + harmonic_extension(tetrahedra, bone_wrap.rows(), template_interior.rows(), displacement);
}

}  // namespace ndg
