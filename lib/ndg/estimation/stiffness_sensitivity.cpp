// SPDX-License-Identifier: Apache-2.0
#include "ndg/estimation/stiffness_sensitivity.h"

#include "ndg/core/error.h"
#include "ndg/elastic/elements.h"
#include "ndg/estimation/material_sensitivity.h"

#include <Eigen/LU>

#include <cmath>

namespace ndg {

namespace {

/// Weights below this count as none.
constexpr double least_weight = 1e-12;

double mean(const Eigen::VectorXd& values, const std::array<int, 4>& corners)
{
    return 0.25 * (values[corners[0]] + values[corners[1]] + values[corners[2]] + values[corners[3]]);
}

}  // namespace

Eigen::VectorXd StiffnessField::young_normal(const Eigen::VectorXd& parameters) const
{
    require(parameters.size() == num_parameters(), "{} parameters instead of {}", parameters.size(), num_parameters());
    return parameters.head(num_points()).array().exp();
}

Eigen::VectorXd StiffnessField::young_tangent(const Eigen::VectorXd& parameters) const
{
    require(parameters.size() == num_parameters(), "{} parameters instead of {}", parameters.size(), num_parameters());
    return parameters.tail(num_points()).array().exp();
}

void StiffnessField::set_stiffness(const Eigen::VectorXd& parameters, SoftBody& body) const
{
    require(weights.rows() == body.num_vertices(), "a field on {} vertices for a body of {}", weights.rows(),
            body.num_vertices());
    body.young_normal_pascal = weights * young_normal(parameters);
    body.young_tangent_pascal = weights * young_tangent(parameters);
}

StiffnessSensitivity::StiffnessSensitivity(const ElasticBody& body, const SoftBody& tissue,
                                           const TissueOptions& options, const StiffnessField& field,
                                           const Eigen::VectorXd& parameters, const Eigen::VectorXd& masses,
                                           double time_step_seconds)
    : objective_(body),
      options_(options),
      material_(field.material),
      num_held_(tissue.num_held),
      hessian_(objective_.hessian_pattern())
{
    require_input(options.law == TissueLaw::fung, "stiffness is estimated of --tissue-law fung alone");
    require(body.num_vertices() == tissue.num_vertices() && masses.size() == tissue.num_vertices(),
            "a body of {} vertices and {} masses for tissue of {}", body.num_vertices(), masses.size(),
            tissue.num_vertices());
    const Eigen::VectorXd normal = field.young_normal(parameters), tangent = field.young_tangent(parameters);
    const int offset = material_ == TissueMaterial::isotropic ? 0 : field.num_points();
    for (Eigen::Index t = 0; t < tissue.tetrahedra.rows(); ++t) {
        Element element;
        Eigen::Vector3d axis = Eigen::Vector3d::Zero();
        Eigen::RowVectorXd share = Eigen::RowVectorXd::Zero(field.num_points());
        for (int a = 0; a < 4; ++a) {
            const int v = tissue.tetrahedra(t, a);
            element.corners[static_cast<std::size_t>(a)] = v;
            axis += 0.25 * tissue.normals.row(v).transpose();
            share += 0.25 * field.weights.row(v);
        }
        const auto rest = corner_positions<4>(tissue.rest, element.corners.data());
        element.gradient = TetrahedronElement::gradient_operator(rest);
        element.volume = TetrahedronElement::volume(rest);
        element.moduli = {mean(tissue.young_normal_pascal, element.corners),
                          mean(tissue.young_tangent_pascal, element.corners), options.poisson_ratio,
                          options.saturation};
        // One for both may differ in the last bit.
        if (material_ == TissueMaterial::isotropic)
            element.moduli.young_tangent_pascal = element.moduli.young_normal_pascal;
        element.material = orthotropic_material(element.moduli, axis);
        for (int c = 0; c < field.num_points(); ++c) {
            if (share[c] < least_weight) continue;
            element.by_normal.emplace_back(c, share[c] * normal[c]);
            element.by_tangent.emplace_back(offset + c, share[c] * tangent[c]);
        }
        elements_.push_back(std::move(element));
    }
    const Eigen::Index free = tissue.num_vertices() - num_held_;
    inertia_.resize(3 * free);
    for (Eigen::Index i = 0; i < free; ++i) {
        inertia_.segment<3>(3 * i).setConstant(masses[num_held_ + i] / (time_step_seconds * time_step_seconds));
    }
    force_ = RowMatrix::Zero(3 * free, field.num_parameters());
    now_ = before_ = Eigen::MatrixXd::Zero(3 * free, field.num_parameters());
    factor_.analyze(hessian_);
}

void StiffnessSensitivity::add_force_derivatives(const Points& positions,
                                                 const std::vector<AffineMap>& world_from_unposed)
{
    const bool unposed = options_.space == DeformationSpace::unposed;
    std::vector<Eigen::Matrix3d> unposed_from_world;
    Points u = positions;
    if (unposed) {
        for (std::size_t v = 0; v < world_from_unposed.size(); ++v) {
            const AffineMap& map = world_from_unposed[v];
            unposed_from_world.push_back(map.leftCols<3>().inverse());
            const auto row = static_cast<Eigen::Index>(v);
            const Eigen::Vector3d x = positions.row(row).transpose();
            u.row(row) = (unposed_from_world.back() * (x - map.col(3))).transpose();
        }
    }
    force_.setZero();
    const auto add = [&](const Element& element, const Eigen::Matrix3d& deformation, Modulus by,
                         const std::vector<std::pair<int, double>>& by_parameter) {
        const Eigen::Matrix<double, 3, 4> forces =
            element.volume * stress_derivative(deformation, element.material, material_derivative(element.moduli, by)) *
            element.gradient;
        for (int a = 0; a < 4; ++a) {
            const int v = element.corners[static_cast<std::size_t>(a)];
            if (v < num_held_) continue;
            Eigen::Vector3d force = forces.col(a);
            if (unposed) force = (unposed_from_world[static_cast<std::size_t>(v)].transpose() * force).eval();
            for (const auto& [parameter, derivative] : by_parameter) {
                for (int c = 0; c < 3; ++c) force_(3 * (v - num_held_) + c, parameter) += derivative * force[c];
            }
        }
    };
    for (const Element& element : elements_) {
        const Eigen::Matrix3d deformation =
            (element.gradient * corner_positions<4>(u, element.corners.data())).transpose();
        if (material_ == TissueMaterial::isotropic) {
            add(element, deformation, Modulus::both, element.by_normal);
        } else {
            add(element, deformation, Modulus::normal, element.by_normal);
            add(element, deformation, Modulus::tangent, element.by_tangent);
        }
    }
}

void StiffnessSensitivity::factorize(const Points& positions)
{
    objective_.hessian(positions, HessianKind::exact, hessian_);
    if (factor_.factorize(hessian_)) return;
    ++num_indefinite_;
    objective_.hessian(positions, HessianKind::projected, hessian_);
    if (!factor_.factorize(hessian_)) throw SolverError("the Hessian at the end of a step is not positive definite");
}

void StiffnessSensitivity::step(const Points& positions, const std::vector<AffineMap>& world_from_unposed)
{
    add_force_derivatives(positions, world_from_unposed);
    factorize(positions);
    const Eigen::MatrixXd right_hand_sides = inertia_.asDiagonal() * (2 * now_ - before_) - force_;
    before_ = std::move(now_);
    now_ = factor_.solve(right_hand_sides);
}

}  // namespace ndg
