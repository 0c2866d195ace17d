// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/nonrigid_fit.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

constexpr double min_normal_cosine = 0.5;
constexpr double extremity_stiffness = 100.0;
constexpr int max_cg_iterations = 15;
constexpr double cg_tolerance = 1e-3;

using SparseMatrix = Eigen::SparseMatrix<double>;

/// One weighted distance along a normal from a place on the surface.
struct Term {
    Eigen::Vector3i vertices;
    Eigen::Vector3d barycentric;
    Eigen::Vector3d normal;
    double residual = 0.0;  ///< at the present positions
    double weight = 0.0;    ///< m^2
};

/// Cotangent weights, none below a small positive one: needles would otherwise pull the wrong way.
SparseMatrix positive_laplacian(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    SparseMatrix laplacian = cotangent_laplacian(vertices, triangles);
    constexpr double least = 0.05;
    for (Eigen::Index column = 0; column < laplacian.outerSize(); ++column) {
        for (SparseMatrix::InnerIterator entry(laplacian, column); entry; ++entry) {
            if (entry.row() != entry.col()) entry.valueRef() = std::min(entry.value(), -least);
        }
    }
    for (Eigen::Index column = 0; column < laplacian.outerSize(); ++column) {
        double sum = 0.0;
        for (SparseMatrix::InnerIterator entry(laplacian, column); entry; ++entry) {
            if (entry.row() != entry.col()) sum += entry.value();
        }
        laplacian.coeffRef(column, column) = -sum;
    }
    return laplacian;
}

std::vector<Term> find_terms(const Points& vertices, const Eigen::Ref<const Triangles>& triangles,
                             const Eigen::VectorXd& areas, const ScanTarget& scan, int scan_samples, double reach,
                             const Eigen::VectorXd& confidence)
{
    const double max_distance = 3.0 * reach;
    std::vector<Term> terms;
    std::vector<int> rows(vertices.rows());
    for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = static_cast<int>(v);
    const Points normals = vertex_normals(vertices, triangles);
    for (const PlaneMatch& match : match_surface_to_scan(vertices, normals, rows, scan, max_distance)) {
        // A quarter of the weight is this direction's, three quarters are the other's.
        terms.push_back({Eigen::Vector3i::Constant(match.vertex), Eigen::Vector3d::UnitX(), match.normal,
                         match.residual,
                         0.25 * (match.residual < 0 ? confidence[match.vertex] : 1.0) * areas[match.vertex] *
                             geman_mcclure(match.residual, reach)});
    }

    const TriangleTree tree(vertices, triangles);
    const Points face_normals = triangle_normals(vertices, triangles);
    const double step = std::max(1.0, static_cast<double>(scan.points.rows()) / scan_samples);
    const auto count = static_cast<Eigen::Index>(static_cast<double>(scan.points.rows()) / step);
    const double area = areas.sum() / static_cast<double>(std::max<Eigen::Index>(count, 1));
    std::vector<Term> found(count);
#pragma omp parallel for schedule(dynamic, 256)
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto row = static_cast<Eigen::Index>(static_cast<double>(i) * step);
        const Eigen::Vector3d position = scan.points.row(row).transpose();
        const ClosestPoint closest = tree.closest(position);
        const Eigen::Vector3d scan_normal = scan.normals.row(row).transpose();
        if (closest.distance > max_distance ||
            scan_normal.dot(face_normals.row(closest.triangle_idx).transpose()) < min_normal_cosine) {
            continue;
        }
        // Interpolated normals: a coarse surface is fitted as the smooth one it stands for.
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        double confident = 0.0;
        for (int k = 0; k < 3; ++k) {
            normal += closest.barycentric[k] * normals.row(triangles(closest.triangle_idx, k)).transpose();
            confident += closest.barycentric[k] * confidence[triangles(closest.triangle_idx, k)];
        }
        normal.normalize();
        const double residual = normal.dot(closest.point - position);
        if (residual >= 0) confident = 1.0;
        found[i] = {triangles.row(closest.triangle_idx).transpose(), closest.barycentric, normal, residual,
                    0.75 * confident * area * geman_mcclure(residual, reach)};
    }
    for (Term& term : found) {
        if (term.weight > 0) terms.push_back(std::move(term));
    }
    return terms;
}

/// sum over terms of weight J^T J applied to displacements, J = barycentric normal^T.
void add_data_product(const std::vector<Term>& terms, const Eigen::MatrixXd& displacement, Eigen::MatrixXd& result)
{
    for (const Term& term : terms) {
        double along = 0.0;
        for (int k = 0; k < 3; ++k) {
            along += term.barycentric[k] * displacement.row(term.vertices[k]).dot(term.normal.transpose());
        }
        along *= term.weight;
        for (int k = 0; k < 3; ++k) {
            result.row(term.vertices[k]) += (along * term.barycentric[k]) * term.normal.transpose();
        }
    }
}

/// Preconditioned conjugate gradients on (regulariser + data + damping) d = right_hand_side, N x 3.
Eigen::MatrixXd solve_step(const SparseMatrix& smoothness, const Eigen::VectorXd& damping,
                           const std::vector<Term>& terms, const SparseCholesky& preconditioner,
                           const Eigen::MatrixXd& right_hand_side)
{
    const auto apply = [&](const Eigen::MatrixXd& x) {
        Eigen::MatrixXd y = smoothness * x;
        y += damping.asDiagonal() * x;
        add_data_product(terms, x, y);
        return y;
    };
    Eigen::MatrixXd solution = Eigen::MatrixXd::Zero(right_hand_side.rows(), 3);
    Eigen::MatrixXd residual = right_hand_side;
    Eigen::MatrixXd preconditioned = preconditioner.solve(residual);
    Eigen::MatrixXd direction = preconditioned;
    double product = residual.cwiseProduct(preconditioned).sum();
    const double first = product;
    for (int iteration = 0; iteration < max_cg_iterations && product > cg_tolerance * cg_tolerance * first;
         ++iteration) {
        const Eigen::MatrixXd applied = apply(direction);
        const double step = product / direction.cwiseProduct(applied).sum();
        solution += step * direction;
        residual -= step * applied;
        preconditioned = preconditioner.solve(residual);
        const double next = residual.cwiseProduct(preconditioned).sum();
        direction = preconditioned + (next / product) * direction;
        product = next;
    }
    return solution;
}

}  // namespace

std::vector<Eigen::Matrix3d> neighbourhood_rotations(const SparseMatrix& laplacian,
                                                     const Eigen::Ref<const Points>& reference,
                                                     const Eigen::Ref<const Points>& deformed)
{
    std::vector<Eigen::Matrix3d> rotations(reference.rows());
#pragma omp parallel for schedule(static)
    for (Eigen::Index v = 0; v < reference.rows(); ++v) {
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for (SparseMatrix::InnerIterator entry(laplacian, v); entry; ++entry) {
            if (entry.row() == v) continue;
            const Eigen::RowVector3d before = reference.row(entry.row()) - reference.row(v);
            const Eigen::RowVector3d after = deformed.row(entry.row()) - deformed.row(v);
            covariance -= entry.value() * after.transpose() * before;
        }
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Matrix3d u = svd.matrixU();
        if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1.0;
        rotations[v] = u * svd.matrixV().transpose();
    }
    return rotations;
}

Eigen::VectorXd stiffness_weights(const SkinnedSurface& skin, double armpit_factor, double armpit_radius)
{
    const SkinPlaces places = find_skin_places(skin);
    const Eigen::VectorXd hands = subtree_weights(skin.weights, {"left_hand", "right_hand"});
    const Eigen::VectorXd toes = subtree_weights(skin.weights, {"left_toes", "right_toes"});
    const Eigen::VectorXd head = subtree_weights(skin.weights, {"head"});
    const Eigen::RowVector3d skull = skin.joint_positions.row(standard_skeleton().joint("head"));
    Eigen::VectorXd result(skin.vertices.rows());
    for (Eigen::Index v = 0; v < result.size(); ++v) {
        // The face: what of the head lies before the middle of the skull.
        const bool is_face = head[v] > 0.5 && skin.vertices(v, 2) > skull[2];
        double stiff = std::max({hands[v], toes[v], is_face ? head[v] : 0.0});
        double exponent = std::log(extremity_stiffness) * stiff;
        const Eigen::Vector3d position = skin.vertices.row(v).transpose();
        const double distance =
            std::min((position - places.left_armpit).norm(), (position - places.right_armpit).norm());
        const double near = std::clamp(2.0 - distance / armpit_radius, 0.0, 1.0);
        exponent = std::max(exponent, std::log(armpit_factor) * near);
        result[v] = std::exp(exponent);
    }
    return result;
}

void describe(OptionList& list, NonrigidFitOptions& options)
{
    list.add("iterations", options.iterations, "of the surface, each round", 1, 1000);
    list.add("first-wavelength", options.first_wavelength, "of displacements, m", 0.005, 10).no_flag();
    list.add("last-wavelength", options.last_wavelength, "shapes smaller than about this are the template's, m", 0.005,
             1);
    list.add("first-reach", options.first_reach, "of the robust weights, m", 1e-4, 10).no_flag();
    list.add("last-reach", options.last_reach, "of the robust weights, m", 1e-4, 10).no_flag();
    list.add("tangential", options.tangential, "weight of staying in place", 0, 1e3).no_flag();
    list.add("scan-samples", options.scan_samples, "scan points matched to the surface", 10, 100000000).no_flag();
}

Points fit_nonrigid(const Eigen::Ref<const Points>& reference, const Eigen::Ref<const Triangles>& triangles,
                    const ScanTarget& scan, const Eigen::Ref<const Points>& start, const Eigen::VectorXd& stiffness,
                    const NonrigidFitOptions& options, const Eigen::VectorXd& given_confidence)
{
    const Eigen::Index count = reference.rows();
    const Eigen::VectorXd confidence = given_confidence.size() > 0 ? given_confidence : Eigen::VectorXd::Ones(count);
    require(start.rows() == count && stiffness.size() == count,
            "{} start positions and {} stiffness values for {} "
            "vertices",
            start.rows(), stiffness.size(), count);
    const SparseMatrix laplacian = positive_laplacian(reference, triangles);
    const Eigen::VectorXd areas = vertex_areas(reference, triangles).cwiseMax(1e-8);
    const Eigen::VectorXd inverse_areas = stiffness.cwiseQuotient(areas);
    const SparseMatrix weighted = laplacian.transpose() * inverse_areas.asDiagonal();
    const SparseMatrix bilaplacian = weighted * laplacian;
    const Eigen::MatrixXd reference_differential = laplacian * reference;

    SparseCholesky preconditioner;
    Points vertices = start;
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
        const double done = options.iterations > 1 ? static_cast<double>(iteration) / (options.iterations - 1) : 1.0;
        const double wavelength =
            options.first_wavelength * std::pow(options.last_wavelength / options.first_wavelength, done);
        const double reach = options.first_reach * std::pow(options.last_reach / options.first_reach, done);
        const double lambda = std::pow(wavelength / (2.0 * EIGEN_PI), 4);

        const std::vector<Term> terms =
            find_terms(vertices, triangles, areas, scan, options.scan_samples, reach, confidence);
        const SparseMatrix smoothness = lambda * bilaplacian;
        const Eigen::VectorXd damping = options.tangential * areas;

        const auto rotations = neighbourhood_rotations(laplacian, reference, vertices);
        Eigen::MatrixXd rotated(count, 3);
        for (Eigen::Index v = 0; v < count; ++v) {
            rotated.row(v) = reference_differential.row(v) * rotations[v].transpose();
        }
        Eigen::MatrixXd right_hand_side = -lambda * (weighted * (laplacian * vertices - rotated));
        for (const Term& term : terms) {
            for (int k = 0; k < 3; ++k) {
                right_hand_side.row(term.vertices[k]) -=
                    (term.weight * term.residual * term.barycentric[k]) * term.normal.transpose();
            }
        }

        SparseMatrix approximate = smoothness;
        for (Eigen::Index v = 0; v < count; ++v) approximate.coeffRef(v, v) += (0.4 + options.tangential) * areas[v];
        approximate.makeCompressed();
        if (iteration == 0) preconditioner.analyze(approximate);
        require(preconditioner.factorize(approximate), "the regulariser of the registration is not positive definite");
        vertices += solve_step(smoothness, damping, terms, preconditioner, right_hand_side);
    }
    return vertices;
}

Points complete_surface(const Eigen::Ref<const Points>& reference, const Eigen::Ref<const Triangles>& triangles,
                        const Eigen::Ref<const Points>& vertices, const Eigen::VectorXd& confidence, double wavelength)
{
    // A vertex given for certain is held this much more firmly than the regulariser pulls.
    constexpr double firmness = 1e3;
    constexpr int rounds = 3;
    const SparseMatrix laplacian = positive_laplacian(reference, triangles);
    const Eigen::VectorXd areas = vertex_areas(reference, triangles).cwiseMax(1e-8);
    const Eigen::VectorXd data = firmness * confidence.cwiseProduct(areas);
    const double lambda = std::pow(wavelength / (2.0 * EIGEN_PI), 4);
    const SparseMatrix weighted = lambda * (laplacian.transpose() * areas.cwiseInverse().asDiagonal());
    SparseMatrix matrix = weighted * laplacian;
    for (Eigen::Index v = 0; v < matrix.rows(); ++v) matrix.coeffRef(v, v) += data[v] + 1e-6 * areas[v];
    matrix.makeCompressed();
    SparseCholesky factor;
    factor.analyze(matrix);
    require(factor.factorize(matrix), "the regulariser of the registration is not positive definite");
    const Eigen::MatrixXd differential = laplacian * reference;
    Points result = vertices;
    for (int round = 0; round < rounds; ++round) {
        const auto rotations = neighbourhood_rotations(laplacian, reference, result);
        Eigen::MatrixXd rotated(reference.rows(), 3);
        for (Eigen::Index v = 0; v < rotated.rows(); ++v) {
            rotated.row(v) = differential.row(v) * rotations[v].transpose();
        }
        result = factor.solve(data.asDiagonal() * vertices + weighted * rotated);
    }
    return result;
}

}  // namespace ndg
