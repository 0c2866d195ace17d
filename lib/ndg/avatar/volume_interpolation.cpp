// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/volume_interpolation.h"

#include "ndg/core/error.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/solver/sparse_cholesky.h"

namespace ndg {

Eigen::SparseMatrix<double> tetrahedral_laplacian(const Eigen::Ref<const Points>& vertices,
                                                  const Eigen::Ref<const Tetrahedra>& tetrahedra)
{
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(16 * std::size_t(tetrahedra.rows()));
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        Eigen::Matrix3d edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = (vertices.row(tetrahedra(t, c + 1)) - vertices.row(tetrahedra(t, 0))).transpose();
        const double volume = edges.determinant() / 6.0;
        require(volume > 0.0, "tetrahedron {} has the volume {:g} m^3", t, volume);
        // Gradients of the barycentric coordinates, one a row.
        Eigen::Matrix<double, 4, 3> gradients;
        gradients.bottomRows<3>() = edges.inverse();
        gradients.row(0) = -gradients.bottomRows<3>().colwise().sum();
        const Eigen::Matrix4d local = volume * gradients * gradients.transpose();
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b) entries.emplace_back(tetrahedra(t, a), tetrahedra(t, b), local(a, b));
    }
    Eigen::SparseMatrix<double> laplacian(vertices.rows(), vertices.rows());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    return laplacian;
}

struct VolumeInterpolation::State {
    std::vector<int> given, free;
    Eigen::SparseMatrix<double> from_given;  ///< free x given
    SparseCholesky solver;
};

VolumeInterpolation::VolumeInterpolation(const Eigen::Ref<const Points>& vertices,
                                         const Eigen::Ref<const Tetrahedra>& tetrahedra,
                                         const std::vector<bool>& is_given)
    : state_(std::make_unique<State>())
{
    const auto count = std::size_t(vertices.rows());
    require(is_given.size() == count, "{} vertices are given or not, of {}", is_given.size(), count);
    std::vector<int> place(count);
    for (std::size_t v = 0; v < count; ++v) {
        std::vector<int>& list = is_given[v] ? state_->given : state_->free;
        place[v] = int(list.size());
        list.push_back(int(v));
    }
    require(!state_->given.empty(), "no vertex of {} is given", count);
    if (state_->free.empty()) return;
    const Eigen::SparseMatrix<double> laplacian = tetrahedral_laplacian(vertices, tetrahedra);
    std::vector<Eigen::Triplet<double>> inner, outer;
    for (Eigen::Index column = 0; column < laplacian.outerSize(); ++column)
        for (Eigen::SparseMatrix<double>::InnerIterator entry(laplacian, column); entry; ++entry) {
            if (is_given[std::size_t(entry.row())]) continue;
            (is_given[std::size_t(column)] ? outer : inner)
                .emplace_back(place[std::size_t(entry.row())], place[std::size_t(column)], entry.value());
        }
    Eigen::SparseMatrix<double> matrix(Eigen::Index(state_->free.size()), Eigen::Index(state_->free.size()));
    matrix.setFromTriplets(inner.begin(), inner.end());
    state_->from_given.resize(Eigen::Index(state_->free.size()), Eigen::Index(state_->given.size()));
    state_->from_given.setFromTriplets(outer.begin(), outer.end());
    state_->solver.analyze(matrix);
    if (!state_->solver.factorize(matrix))
        throw SolverError("interpolation into the volume: a vertex is connected to none of those given");
}

VolumeInterpolation::~VolumeInterpolation() = default;

RowMatrix VolumeInterpolation::interpolate(const Eigen::Ref<const RowMatrix>& values) const
{
    const auto count = Eigen::Index(state_->given.size() + state_->free.size());
    require(values.rows() == count, "{} rows of values were given for {} vertices", values.rows(), count);
    RowMatrix result = values;
    if (state_->free.empty()) return result;
    Eigen::MatrixXd given(Eigen::Index(state_->given.size()), values.cols());
    for (std::size_t i = 0; i < state_->given.size(); ++i) given.row(Eigen::Index(i)) = values.row(state_->given[i]);
    const Eigen::MatrixXd right = -(state_->from_given * given);
    const Eigen::MatrixXd solution = state_->solver.solve(right);
    for (std::size_t i = 0; i < state_->free.size(); ++i) result.row(state_->free[i]) = solution.row(Eigen::Index(i));
    return result;
}

}  // namespace ndg
