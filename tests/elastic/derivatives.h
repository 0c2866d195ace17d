// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/objective.h"

#include <catch2/catch.hpp>

namespace ndg::test {

inline Eigen::MatrixXd hessian_of(const Objective& objective, const Points& positions, HessianKind kind)
{
    Eigen::SparseMatrix<double> matrix = objective.hessian_pattern();
    objective.hessian(positions, kind, matrix);
    const Eigen::MatrixXd lower(matrix);
    return lower.selfadjointView<Eigen::Lower>();
}

/// Gradient and exact Hessian against differences of energy and gradient.
inline void require_derivatives(const Objective& objective, const Points& x)
{
    Eigen::VectorXd gradient, absolute, plus_gradient, minus_gradient, scratch;
    objective.gradient(x, gradient, absolute);
    REQUIRE(gradient.norm() > 1e-2);
    REQUIRE((absolute.array() >= gradient.array().abs() - 1e-12).all());
    const Eigen::MatrixXd hessian = hessian_of(objective, x, HessianKind::exact);
    Eigen::VectorXd numeric(objective.num_unknowns());
    Eigen::MatrixXd numeric_hessian(objective.num_unknowns(), objective.num_unknowns());
    const double step = 1e-6;
    for (int d = 0; d < objective.num_unknowns(); ++d) {
        Points plus = x, minus = x;
        const int vertex = objective.vertices()[d / 3];
        plus(vertex, d % 3) += step;
        minus(vertex, d % 3) -= step;
        numeric(d) = (objective.energy(plus) - objective.energy(minus)) / (2 * step);
        objective.gradient(plus, plus_gradient, scratch);
        objective.gradient(minus, minus_gradient, scratch);
        numeric_hessian.col(d) = (plus_gradient - minus_gradient) / (2 * step);
    }
    REQUIRE((gradient - numeric).norm() < 1e-6 * gradient.norm());
    REQUIRE(hessian.norm() > 1);
    REQUIRE((hessian - numeric_hessian).norm() < 1e-6 * hessian.norm());
}

}  // namespace ndg::test
