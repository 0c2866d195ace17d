// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/prism.h"

#include "ndg/core/error.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace ndg {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A prism whose centred vertices span a slab thinner than this share of its extent counts as flat.
constexpr double flat_ratio = 1e-8;

struct ReferencePoint {
    double alpha, beta, xi;
};

/// Half the area of the reference triangle: the weight of both points of Gauss' rule.
constexpr double quadrature_weight = 0.25;

/// The two quadrature points of supplement equation 16.
std::array<ReferencePoint, 2> quadrature_points()
{
    const double offset = 1.0 / std::sqrt(3.0);
    return {{{1.0 / 3.0, 1.0 / 3.0, 0.5 * (1.0 - offset)}, {1.0 / 3.0, 1.0 / 3.0, 0.5 * (1.0 + offset)}}};
}

/// Six corners, then the two quadrature points.
std::array<ReferencePoint, 8> validity_points()
{
    const auto quadrature = quadrature_points();
    return {{{1, 0, 1}, {0, 1, 1}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, quadrature[0], quadrature[1]}};
}

/// Edges of a prism: at a corner the columns of J are the two of its triangle and the one to the other triangle.
struct PrismEdges {
    Eigen::Vector3d top[2], bottom[2], across[3];

    explicit PrismEdges(const PrismVertices& prism)
    {
        for (int k = 0; k < 2; ++k) {
            top[k] = prism.row(k) - prism.row(2);
            bottom[k] = prism.row(3 + k) - prism.row(5);
        }
        for (int k = 0; k < 3; ++k) across[k] = prism.row(k) - prism.row(3 + k);
    }

    double smallest_at_corners() const
    {
        const Eigen::Vector3d above = top[0].cross(top[1]), below = bottom[0].cross(bottom[1]);
        double smallest = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector3d& edge : across) smallest = std::min({smallest, above.dot(edge), below.dot(edge)});
        return smallest;
    }

    double smallest_at_quadrature_points() const
    {
        const Eigen::Vector3d middle = (across[0] + across[1] + across[2]) / 3.0;
        double smallest = std::numeric_limits<double>::infinity();
        for (const ReferencePoint& at : quadrature_points()) {
            const Eigen::Vector3d first = at.xi * top[0] + (1 - at.xi) * bottom[0];
            const Eigen::Vector3d second = at.xi * top[1] + (1 - at.xi) * bottom[1];
            smallest = std::min(smallest, first.cross(second).dot(middle));
        }
        return smallest;
    }
};

/// Derivatives of the shape functions with respect to (alpha, beta, xi), one a column.
Eigen::Matrix<double, 6, 3> shape_derivatives(double alpha, double beta, double xi)
{
    const double gamma = 1.0 - alpha - beta;
    Eigen::Matrix<double, 6, 3> derivatives;
    derivatives << xi, 0, alpha,  //
        0, xi, beta,              //
        -xi, -xi, gamma,          //
        1 - xi, 0, -alpha,        //
        0, 1 - xi, -beta,         //
        -(1 - xi), -(1 - xi), -gamma;
    return derivatives;
}

/// d det J / d P = D cof(J)^T, because J = P^T D; the columns of cof(J) are cross products of those of J.
PrismVertices determinant_gradient(const PrismVertices& prism, const ReferencePoint& at)
{
    const Eigen::Matrix3d jacobian = prism_jacobian(prism, at.alpha, at.beta, at.xi);
    Eigen::Matrix3d cofactors;
    cofactors.col(0) = jacobian.col(1).cross(jacobian.col(2));
    cofactors.col(1) = jacobian.col(2).cross(jacobian.col(0));
    cofactors.col(2) = jacobian.col(0).cross(jacobian.col(1));
    return shape_derivatives(at.alpha, at.beta, at.xi) * cofactors.transpose();
}

/// det J is linear in each vertex: block (a, b) of its Hessian is the cross product matrix of -J (d_a x d_b), where d_a
/// is row a of D.
Eigen::Matrix<double, 18, 18> determinant_hessian(const PrismVertices& prism, const ReferencePoint& at)
{
    Eigen::Matrix<double, 18, 18> hessian;
    const Eigen::Matrix3d jacobian = prism_jacobian(prism, at.alpha, at.beta, at.xi);
    const Eigen::Matrix<double, 6, 3> derivatives = shape_derivatives(at.alpha, at.beta, at.xi);
    for (int a = 0; a < 6; ++a) {
        for (int b = 0; b < 6; ++b) {
            const Eigen::Vector3d d_a = derivatives.row(a).transpose(), d_b = derivatives.row(b).transpose();
            const Eigen::Vector3d v = -(jacobian * d_a.cross(d_b));
            Eigen::Matrix3d cross;
            cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
            hessian.block<3, 3>(3 * a, 3 * b) = cross;
        }
    }
    return hessian;
}

/// W of supplement equation 6.
Matrix6 weight_matrix()
{
    Matrix6 weights;
    for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 6; ++j) {
            const bool same_triangle = i / 3 == j / 3;
            const bool vertical = i % 3 == j % 3;
            weights(i, j) = i == j ? 4.0 : (same_triangle || vertical ? 2.0 : 1.0);
        }
    }
    return weights;
}

/// Newton's method from one start, with the step halved until the residual falls.
PrismCoordinates newton(const PrismVertices& prism, const Eigen::RowVector3d& point, const Eigen::Vector3d& start,
                        double tolerance)
{
    constexpr int max_iterations = 60;
    constexpr int max_halvings = 30;
    Eigen::Vector3d coords = start;
    const auto residual_at = [&](const Eigen::Vector3d& at) -> Eigen::Vector3d {
        return (prism_point(prism, at[0], at[1], at[2]) - point).transpose();
    };
    Eigen::Vector3d residual = residual_at(coords);
    double norm = residual.norm();
    for (int iteration = 0; iteration < max_iterations && norm > 0.0; ++iteration) {
        const Eigen::Vector3d step =
            prism_jacobian(prism, coords[0], coords[1], coords[2]).partialPivLu().solve(-residual);
        if (!step.allFinite()) break;
        double length = 1.0;
        bool fell = false;
        for (int halving = 0; halving < max_halvings && !fell; ++halving, length *= 0.5) {
            const Eigen::Vector3d trial = coords + length * step;
            const Eigen::Vector3d trial_residual = residual_at(trial);
            if (trial_residual.norm() < norm) {
                coords = trial;
                residual = trial_residual;
                norm = residual.norm();
                fell = true;
            }
        }
        if (!fell) break;
    }
    return {coords[0], coords[1], coords[2], norm <= tolerance};
}

/// How far (alpha, beta, xi) lies outside the reference prism; zero inside.
double distance_outside(const PrismCoordinates& c)
{
    const double gamma = 1.0 - c.alpha - c.beta;
    return std::max({-c.alpha, -c.beta, -gamma, -c.xi, c.xi - 1.0, 0.0});
}

}  // namespace

PrismVertices gather_prism(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms,
                           Eigen::Index prism_idx)
{
    PrismVertices prism;
    for (int corner = 0; corner < 6; ++corner) prism.row(corner) = vertices.row(prisms(prism_idx, corner));
    return prism;
}

Eigen::RowVector3d prism_point(const PrismVertices& prism, double alpha, double beta, double xi)
{
    return prism_shape_functions(alpha, beta, xi).transpose() * prism;
}

Vector6 prism_shape_functions(double alpha, double beta, double xi)
{
    const double gamma = 1.0 - alpha - beta;
    Vector6 values;
    values << xi * alpha, xi * beta, xi * gamma, (1 - xi) * alpha, (1 - xi) * beta, (1 - xi) * gamma;
    return values;
}

Eigen::Matrix3d prism_jacobian(const PrismVertices& prism, double alpha, double beta, double xi)
{
    return prism.transpose() * shape_derivatives(alpha, beta, xi);
}

double prism_volume(const PrismVertices& prism)
{
    double sum = 0.0;
    for (const auto& at : quadrature_points()) sum += prism_jacobian(prism, at.alpha, at.beta, at.xi).determinant();
    return quadrature_weight * sum;
}

PrismVertices prism_volume_gradient(const PrismVertices& prism)
{
    PrismVertices gradient = PrismVertices::Zero();
    for (const auto& at : quadrature_points()) gradient += quadrature_weight * determinant_gradient(prism, at);
    return gradient;
}

Eigen::Matrix<double, 18, 18> prism_volume_hessian(const PrismVertices& prism)
{
    Eigen::Matrix<double, 18, 18> hessian = Eigen::Matrix<double, 18, 18>::Zero();
    for (const auto& at : quadrature_points()) hessian += quadrature_weight * determinant_hessian(prism, at);
    return hessian;
}

double prism_corner_jacobian(const PrismVertices& prism, int corner)
{
    const ReferencePoint at = validity_points()[corner];
    return prism_jacobian(prism, at.alpha, at.beta, at.xi).determinant();
}

PrismVertices prism_corner_jacobian_gradient(const PrismVertices& prism, int corner)
{
    return determinant_gradient(prism, validity_points()[corner]);
}

Eigen::Matrix<double, 18, 18> prism_corner_jacobian_hessian(const PrismVertices& prism, int corner)
{
    return determinant_hessian(prism, validity_points()[corner]);
}

double prism_min_jacobian(const PrismVertices& prism)
{
    const PrismEdges edges(prism);
    return std::min(edges.smallest_at_corners(), edges.smallest_at_quadrature_points());
}

double prism_min_corner_jacobian(const PrismVertices& prism)
{
    return PrismEdges(prism).smallest_at_corners();
}

double prism_min_scaled_jacobian(const PrismVertices& prism)
{
    const double ideal = std::sqrt(3.0) / 2.0;
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto& at : validity_points()) {
        Eigen::Matrix3d jacobian = prism_jacobian(prism, at.alpha, at.beta, at.xi);
        const Eigen::RowVector3d lengths = jacobian.colwise().norm();
        double scaled = 0.0;
        if (lengths.minCoeff() > 0.0) {
            for (int column = 0; column < 3; ++column) jacobian.col(column) /= lengths[column];
            scaled = jacobian.determinant() / ideal;
        }
        smallest = std::min(smallest, scaled);
    }
    return smallest;
}

PrismGradient prism_gradient_operator(const PrismVertices& rest)
{
    // With W = L L^T the normal equations of equation 7 are those of min |L^T Pc F^T - L^T C P|. Q R = L^T Pc solves
    // them without squaring the condition number (thin prisms are common): G = R^-1 Q^T L^T C.
    static const Matrix6 factor_transposed = weight_matrix().llt().matrixU();
    PrismVertices q = factor_transposed * (rest.rowwise() - rest.colwise().mean());
    const double extent = q.norm();
    Eigen::Matrix3d r = Eigen::Matrix3d::Zero();
    for (int column = 0; column < 3; ++column) {
        // Gram-Schmidt twice keeps the columns orthogonal to rounding even for very thin prisms.
        for (int pass = 0; pass < 2; ++pass) {
            for (int before = 0; before < column; ++before) {
                const double share = q.col(before).dot(q.col(column));
                r(before, column) += share;
                q.col(column) -= share * q.col(before);
            }
        }
        r(column, column) = q.col(column).norm();
        if (!(r(column, column) > flat_ratio * extent)) {
            throw Error("a flat rest prism has no gradient operator (its vertices lie in one plane)");
        }
        q.col(column) /= r(column, column);
    }
    PrismGradient raw = q.transpose() * factor_transposed;
    raw.row(2) /= r(2, 2);
    raw.row(1) = (raw.row(1) - r(1, 2) * raw.row(2)).eval() / r(1, 1);
    raw.row(0) = (raw.row(0) - r(0, 1) * raw.row(1) - r(0, 2) * raw.row(2)).eval() / r(0, 0);
    return raw.colwise() - raw.rowwise().mean();
}

Eigen::SparseMatrix<double> gradient_operator(const Eigen::Ref<const Points>& rest_vertices,
                                              const Eigen::Ref<const Prisms>& prisms)
{
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(18 * prisms.rows()));
    for (Eigen::Index prism_idx = 0; prism_idx < prisms.rows(); ++prism_idx) {
        PrismGradient gradient;
        try {
            gradient = prism_gradient_operator(gather_prism(rest_vertices, prisms, prism_idx));
        } catch (const Error& error) {
            throw Error(fmt::format("prism {}: {}", prism_idx, error.what()));
        }
        for (int corner = 0; corner < 6; ++corner) {
            for (int axis = 0; axis < 3; ++axis) {
                entries.emplace_back(static_cast<int>(3 * prism_idx + axis), prisms(prism_idx, corner),
                                     gradient(axis, corner));
            }
        }
    }
    Eigen::SparseMatrix<double> result(3 * prisms.rows(), rest_vertices.rows());
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
}

Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> deformation_gradients(
    const Eigen::SparseMatrix<double>& gradient_operator, const Eigen::Ref<const Points>& vertices)
{
    require(gradient_operator.cols() == vertices.rows(), "the gradient operator acts on {} vertices, but {} were given",
            gradient_operator.cols(), vertices.rows());
    const Points transposed = gradient_operator * vertices;
    Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> result(transposed.rows() / 3, 9);
    for (Eigen::Index prism_idx = 0; prism_idx < result.rows(); ++prism_idx) {
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                result(prism_idx, 3 * row + column) = transposed(3 * prism_idx + column, row);
            }
        }
    }
    return result;
}

Eigen::VectorXd prism_volumes(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms)
{
    Eigen::VectorXd volumes(prisms.rows());
    for (Eigen::Index prism_idx = 0; prism_idx < prisms.rows(); ++prism_idx) {
        volumes[prism_idx] = prism_volume(gather_prism(vertices, prisms, prism_idx));
    }
    return volumes;
}

InvertedPrisms count_inverted_prisms(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms)
{
    InvertedPrisms count;
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        const PrismVertices prism = gather_prism(vertices, prisms, p);
        count.by_volume += prism_volume(prism) < 0;
        count.at_corners += prism_min_corner_jacobian(prism) < 0;
    }
    return count;
}

PrismCoordinates prism_coordinates(const PrismVertices& prism, const Eigen::RowVector3d& point)
{
    const double extent = (prism.colwise().maxCoeff() - prism.colwise().minCoeff()).norm();
    const double reach = extent + (point - prism.colwise().mean()).norm();
    const double tolerance = 1e-12 * reach;
    const double third = 1.0 / 3.0;
    // The map is cubic, so a point may have several pre-images: the one nearest the reference prism is wanted. The
    // centre alone finds it for all but badly twisted prisms.
    PrismCoordinates best = newton(prism, point, {third, third, 0.5}, tolerance);
    if (best.converged && distance_outside(best) <= 0.0) return best;
    for (const double xi : {0.0, 1.0}) {
        const PrismCoordinates other = newton(prism, point, {third, third, xi}, tolerance);
        const bool nearer = distance_outside(other) < distance_outside(best);
        if (other.converged && (!best.converged || nearer)) best = other;
    }
    return best;
}

}  // namespace ndg
