// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/bone_interior.h"

#include "ndg/core/error.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/tetrahedralize.h"
#include "ndg/solver/sparse_cholesky.h"

#include <fmt/format.h>

#include <algorithm>
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
