// SPDX-License-Identifier: Apache-2.0
// How a motion of soft tissue changes with the stiffness at its control points: forward sensitivities of implicit
// Euler.
#pragma once

#include "ndg/dynamics/driven_body.h"
#include "ndg/elastic/objective.h"
#include "ndg/elastic/orthotropic_material.h"
#include "ndg/solver/sparse_cholesky.h"

#include <array>
#include <utility>
#include <vector>

namespace ndg {

/// Parameters are logarithms of Young's moduli at C points: first those along the normal, then those across it; or, for
/// an isotropic material, one for each point.
enum class TissueMaterial { anisotropic, isotropic };
template <>
inline constexpr EnumName<TissueMaterial> enum_table<TissueMaterial>[] = {{TissueMaterial::anisotropic, "anisotropic"},
                                                                          {TissueMaterial::isotropic, "isotropic"}};

struct StiffnessField {
    RowMatrix weights;  ///< M x C: values at the points to values at the vertices, rows summing to one
    TissueMaterial material = TissueMaterial::anisotropic;

    int num_points() const { return static_cast<int>(weights.cols()); }
    int num_parameters() const { return material == TissueMaterial::isotropic ? num_points() : 2 * num_points(); }
    /// Pa, C each, of parameters.
    Eigen::VectorXd young_normal(const Eigen::VectorXd& parameters) const;
    Eigen::VectorXd young_tangent(const Eigen::VectorXd& parameters) const;
    /// Sets the moduli of a body of M vertices. Throws Error for other numbers.
    void set_stiffness(const Eigen::VectorXd& parameters, SoftBody& body) const;
};

/// A step ends where g(x_n; x_{n-1}, x_{n-2}, d) = M / h^2 (x_n - 2 x_{n-1} + x_{n-2}) + dU / dx (x_n, d) = 0. With
/// S_n = dx_n / dd, H S_n = M / h^2 (2 S_{n-1} - S_{n-2}) - d^2 U / (dx dd), H the Hessian that Newton's method has
/// there: one factor a step, as many right-hand sides as there are parameters. What is held, and where and how fast a
/// motion starts, depends on no stiffness.
class StiffnessSensitivity {
public:
    /// Keeps a reference to `body`, which must be made of `tissue` already, and to which an integrator has added its
    /// terms. Throws InputError for flesh of another law than Fung's.
    StiffnessSensitivity(const ElasticBody& body, const SoftBody& tissue, const TissueOptions& options,
                         const StiffnessField& field, const Eigen::VectorXd& parameters, const Eigen::VectorXd& masses,
                         double time_step_seconds);

    /// At the end of a step, where the energy of `body` is that of the step.
    void step(const Points& positions, const std::vector<AffineMap>& world_from_unposed);

    /// 3 F x P, row 3 i + c coordinate c of the i-th free vertex (vertex num_held + i), m per unit of a parameter.
    const Eigen::MatrixXd& positions_by_parameters() const { return now_; }
    /// Steps whose Hessian was not positive definite, where the projected one stood in.
    int num_indefinite() const { return num_indefinite_; }

private:
    void add_force_derivatives(const Points& positions, const std::vector<AffineMap>& world_from_unposed);
    void factorize(const Points& positions);

    /// Of one element: what does not change from step to step.
    struct Element {
        std::array<int, 4> corners;
        Eigen::Matrix<double, 3, 4> gradient;
        double volume = 0;
        OrthotropicMaterial material;
        std::vector<std::pair<int, double>> by_normal, by_tangent;  ///< dY / d parameter, where it is not zero
        OrthotropicModuli moduli;
    };

    Objective objective_;
    TissueOptions options_;
    TissueMaterial material_;
    std::vector<Element> elements_;
    int num_held_ = 0;
    Eigen::VectorXd inertia_;  ///< 3 F, M / h^2
    Eigen::SparseMatrix<double> hessian_;
    SparseCholesky factor_;
    RowMatrix force_;  ///< 3 F x P, d^2 U / (dx dd)
    Eigen::MatrixXd now_, before_;
    int num_indefinite_ = 0;
};

}  // namespace ndg
