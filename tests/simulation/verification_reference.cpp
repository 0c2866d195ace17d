// SPDX-License-Identifier: Apache-2.0
#include "verification_reference.h"

#include "ndg/core/error.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>

namespace ndg::test {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<std::array<int, 2>, 6> edge_corners{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Middles of edges as new nodes behind the old ones.
class Middles {
public:
    explicit Middles(const SolidMesh& mesh) : next_(mesh.num_nodes()) {}
    int of(int a, int b)
    {
        const auto [found, added] = nodes_.try_emplace({std::min(a, b), std::max(a, b)}, next_);
        next_ += added;
        return found->second;
    }
    void append_to(SolidMesh& mesh) const
    {
        mesh.rest.conservativeResize(next_, 3);
        mesh.positions.conservativeResize(next_, 3);
        mesh.held.resize(next_);
        for (const auto& [edge, node] : nodes_) {
            mesh.rest.row(node) = 0.5 * (mesh.rest.row(edge.first) + mesh.rest.row(edge.second));
            mesh.positions.row(node) = 0.5 * (mesh.positions.row(edge.first) + mesh.positions.row(edge.second));
            mesh.held[node] = mesh.held[edge.first] && mesh.held[edge.second];
        }
    }

private:
    std::map<std::pair<int, int>, int> nodes_;
    int next_;
};

Matrix3d corner_edges(const Points& points, const RowMatrixI& elements, Eigen::Index t)
{
    Matrix3d edges;
    for (int c = 0; c < 3; ++c) {
        edges.col(c) = (points.row(elements(t, c + 1)) - points.row(elements(t, 0))).transpose();
    }
    return edges;
}

Matrix3d cofactor(const Matrix3d& f)
{
    Matrix3d result;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            result(i, j) = f(i1, j1) * f(i2, j2) - f(i1, j2) * f(i2, j1);
        }
    }
    return result;
}

/// Derivative of the cofactor matrix, which is quadratic, along `change`.
Matrix3d cofactor_change(const Matrix3d& f, const Matrix3d& change)
{
    return 0.5 * (cofactor(f + change) - cofactor(f - change));
}

double density(const Matrix3d& f, const Lame& lame)
{
    const double dilation = f.determinant() - 1;
    return 0.5 * lame.mu * (f.squaredNorm() - 3) - lame.mu * dilation + 0.5 * lame.lambda * dilation * dilation;
}

Matrix3d stress(const Matrix3d& f, const Lame& lame)
{
    return lame.mu * f + (lame.lambda * (f.determinant() - 1) - lame.mu) * cofactor(f);
}

Matrix3d stress_change(const Matrix3d& f, const Matrix3d& change, const Lame& lame)
{
    const Matrix3d volume_gradient = cofactor(f);
    return lame.mu * change + lame.lambda * volume_gradient.cwiseProduct(change).sum() * volume_gradient +
           (lame.lambda * (f.determinant() - 1) - lame.mu) * cofactor_change(f, change);
}

using ShapeGradients = Eigen::Matrix<double, 10, 3>;

/// The four points of degree two, each of a quarter of the volume: f(gradients of the shape functions, weight).
template <class Visit>
void visit_quadrature(const SolidMesh& mesh, Eigen::Index t, const Visit& visit)
{
    const Matrix3d edges = corner_edges(mesh.rest, mesh.elements, t);
    Eigen::Matrix<double, 4, 3> corner_gradients;
    corner_gradients.bottomRows<3>() = edges.inverse();
    corner_gradients.row(0) = -corner_gradients.bottomRows<3>().colwise().sum();
    const double far = 0.1381966011250105, near = 1 - 3 * far;
    for (int q = 0; q < 4; ++q) {
        Eigen::Vector4d at = Eigen::Vector4d::Constant(far);
        at(q) = near;
        ShapeGradients gradients;
        for (int a = 0; a < 4; ++a) gradients.row(a) = (4 * at(a) - 1) * corner_gradients.row(a);
        for (int e = 0; e < 6; ++e) {
            const auto [a, b] = edge_corners[e];
            gradients.row(4 + e) = 4 * (at(a) * corner_gradients.row(b) + at(b) * corner_gradients.row(a));
        }
        visit(gradients, edges.determinant() / 24);
    }
}

Matrix3d deformation(const SolidMesh& mesh, Eigen::Index t, const ShapeGradients& gradients)
{
    Matrix3d f = Matrix3d::Zero();
    for (int a = 0; a < 10; ++a) f += mesh.positions.row(mesh.elements(t, a)).transpose() * gradients.row(a);
    return f;
}

const Lame& material(const SolidMesh& mesh, const std::array<Lame, 2>& lame, Eigen::Index t)
{
    return lame[mesh.materials[t]];
}

/// Place of every node among the unknowns, -1 for the held ones and those of no element.
std::vector<int> unknown_nodes(const SolidMesh& mesh)
{
    std::vector<int> unknown(mesh.held.size(), -1);
    for (Eigen::Index i = 0; i < mesh.elements.size(); ++i) {
        const auto node = static_cast<std::size_t>(mesh.elements.data()[i]);
        if (!mesh.held[node]) unknown[node] = 0;
    }
    int count = 0;
    for (int& place : unknown) {
        if (place == 0) place = count++;
    }
    return unknown;
}

Eigen::SparseMatrix<double> stiffness(const SolidMesh& mesh, const std::array<Lame, 2>& lame,
                                      const std::vector<int>& unknown, int num_unknown)
{
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index t = 0; t < mesh.elements.rows(); ++t) {
        Eigen::Matrix<double, 30, 30> element = Eigen::Matrix<double, 30, 30>::Zero();
        visit_quadrature(mesh, t, [&](const ShapeGradients& gradients, double weight) {
            const Matrix3d f = deformation(mesh, t, gradients);
            for (int b = 0; b < 10; ++b) {
                for (int j = 0; j < 3; ++j) {
                    const Matrix3d change = Vector3d::Unit(j) * gradients.row(b);
                    const Matrix3d forces = weight * stress_change(f, change, material(mesh, lame, t));
                    for (int a = 0; a < 10; ++a) {
                        element.block<3, 1>(3 * a, 3 * b + j) += forces * gradients.row(a).transpose();
                    }
                }
            }
        });
        for (int row = 0; row < 30; ++row) {
            for (int column = 0; column < 30; ++column) {
                const int i = unknown[mesh.elements(t, row / 3)];
                const int j = unknown[mesh.elements(t, column / 3)];
                if (i < 0 || j < 0 || 3 * i + row % 3 < 3 * j + column % 3) continue;
                entries.emplace_back(3 * i + row % 3, 3 * j + column % 3, element(row, column));
            }
        }
    }
    Eigen::SparseMatrix<double> matrix(3 * num_unknown, 3 * num_unknown);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

}  // namespace

SolidMesh SolidMesh::refined() const
{
    SolidMesh fine = *this;
    Middles middles(*this);
    fine.elements.resize(8 * elements.rows(), 4);
    fine.materials.clear();
    Eigen::Index row = 0;
    for (Eigen::Index t = 0; t < elements.rows(); ++t) {
        const int v0 = elements(t, 0), v1 = elements(t, 1), v2 = elements(t, 2), v3 = elements(t, 3);
        const int m01 = middles.of(v0, v1), m02 = middles.of(v0, v2), m03 = middles.of(v0, v3);
        const int m12 = middles.of(v1, v2), m13 = middles.of(v1, v3), m23 = middles.of(v2, v3);
        const int children[8][4] = {{v0, m01, m02, m03},  {v1, m01, m12, m13},  {v2, m02, m12, m23},
                                    {v3, m03, m13, m23},  {m01, m02, m03, m13}, {m01, m02, m12, m13},
                                    {m02, m03, m13, m23}, {m02, m12, m13, m23}};
        for (const auto& child : children) {
            for (int c = 0; c < 4; ++c) fine.elements(row, c) = child[c];
            ++row;
            fine.materials.push_back(materials[t]);
        }
    }
    middles.append_to(fine);
    for (Eigen::Index t = 0; t < fine.elements.rows(); ++t) {
        if (corner_edges(fine.rest, fine.elements, t).determinant() < 0) {
            std::swap(fine.elements(t, 2), fine.elements(t, 3));
        }
    }
    return fine;
}

SolidMesh SolidMesh::quadratic() const
{
    SolidMesh result = *this;
    Middles middles(*this);
    result.elements.conservativeResize(Eigen::NoChange, 10);
    for (Eigen::Index t = 0; t < elements.rows(); ++t) {
        for (int e = 0; e < 6; ++e) {
            const auto [a, b] = edge_corners[e];
            result.elements(t, 4 + e) = middles.of(elements(t, a), elements(t, b));
        }
    }
    middles.append_to(result);
    return result;
}

SolidMesh split_prisms(const Points& rest, const Points& positions, const Prisms& prisms, int fat_begin,
                       const std::vector<int>& free)
{
    SolidMesh mesh;
    mesh.rest = rest;
    mesh.positions = positions;
    mesh.held.assign(rest.rows(), 1);
    for (const int v : free) mesh.held[v] = 0;
    mesh.elements.resize(3 * prisms.rows(), 4);
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        // The diagonals of the sides run from the column of the lowest number upwards, so neighbours agree.
        std::array<int, 3> columns{0, 1, 2};
        std::sort(columns.begin(), columns.end(), [&](int a, int b) { return prisms(p, 3 + a) < prisms(p, 3 + b); });
        const auto low = [&](int c) { return prisms(p, 3 + columns[c]); };
        const auto high = [&](int c) { return prisms(p, columns[c]); };
        mesh.elements.row(3 * p) << low(0), low(1), low(2), high(2);
        mesh.elements.row(3 * p + 1) << low(0), low(1), high(2), high(1);
        mesh.elements.row(3 * p + 2) << low(0), high(0), high(1), high(2);
        for (int part = 0; part < 3; ++part) {
            mesh.materials.push_back(p >= fat_begin);
            const Eigen::Index t = 3 * p + part;
            if (corner_edges(rest, mesh.elements, t).determinant() < 0) {
                std::swap(mesh.elements(t, 2), mesh.elements(t, 3));
            }
        }
    }
    return mesh;
}

double solid_energy(const SolidMesh& mesh, const std::array<Lame, 2>& lame)
{
    double sum = 0;
    for (Eigen::Index t = 0; t < mesh.elements.rows(); ++t) {
        visit_quadrature(mesh, t, [&](const ShapeGradients& gradients, double weight) {
            sum += weight * density(deformation(mesh, t, gradients), material(mesh, lame, t));
        });
    }
    return sum;
}

Points solid_forces(const SolidMesh& mesh, const std::array<Lame, 2>& lame)
{
    Points forces = Points::Zero(mesh.num_nodes(), 3);
    for (Eigen::Index t = 0; t < mesh.elements.rows(); ++t) {
        visit_quadrature(mesh, t, [&](const ShapeGradients& gradients, double weight) {
            const Matrix3d pull = weight * stress(deformation(mesh, t, gradients), material(mesh, lame, t));
            for (int a = 0; a < 10; ++a) {
                forces.row(mesh.elements(t, a)) += gradients.row(a) * pull.transpose();
            }
        });
    }
    return forces;
}

SolidEquilibrium solve(SolidMesh& mesh, const std::array<Lame, 2>& lame)
{
    const std::vector<int> unknown = unknown_nodes(mesh);
    const int num_unknown = 1 + *std::max_element(unknown.begin(), unknown.end());
    SolidEquilibrium result;
    result.energy = solid_energy(mesh, lame);
    SparseCholesky solver;
    Eigen::VectorXd gradient(3 * num_unknown);
    for (;; ++result.iterations) {
        const Points forces = solid_forces(mesh, lame);
        for (std::size_t v = 0; v < unknown.size(); ++v) {
            if (unknown[v] >= 0) {
                gradient.segment<3>(3 * unknown[v]) = forces.row(static_cast<Eigen::Index>(v)).transpose();
            }
        }
        result.residual = gradient.norm();
        if (result.residual < 1e-9) return result;
        require(result.iterations < 40, "the reference is still {} N out of balance", result.residual);
        Eigen::SparseMatrix<double> matrix = stiffness(mesh, lame, unknown, num_unknown);
        if (result.iterations == 0) solver.analyze(matrix);
        // Away from the minimum the matrix can be indefinite.
        double shift = 1e-3 * matrix.diagonal().mean();
        for (; !solver.factorize(matrix); shift *= 4) matrix.diagonal().array() += shift;
        const Eigen::VectorXd move = solver.solve(-gradient);
        const Points start = mesh.positions;
        double energy = result.energy;
        for (double step = 1; step > 1e-10; step *= 0.5) {
            for (std::size_t v = 0; v < unknown.size(); ++v) {
                if (unknown[v] < 0) continue;
                const auto row = static_cast<Eigen::Index>(v);
                mesh.positions.row(row) = start.row(row) + step * move.segment<3>(3 * unknown[v]).transpose();
            }
            energy = solid_energy(mesh, lame);
            // Near the minimum rounding hides the decrease.
            if (energy <= result.energy + 1e-12 * std::abs(result.energy)) break;
        }
        result.energy = energy;
    }
}

}  // namespace ndg::test
