// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace ndg::test {

/// Largest difference between a gradient and central differences, relative to the largest entry.
template <typename Energy>
double gradient_error(const Energy& energy, const Eigen::MatrixXd& at, const Eigen::MatrixXd& gradient, double step)
{
    double worst = 0.0;
    for (Eigen::Index i = 0; i < at.rows(); ++i)
        for (Eigen::Index c = 0; c < at.cols(); ++c) {
            Eigen::MatrixXd plus = at, minus = at;
            plus(i, c) += step;
            minus(i, c) -= step;
            worst = std::max(worst, std::abs((energy(plus) - energy(minus)) / (2.0 * step) - gradient(i, c)));
        }
    return worst / gradient.cwiseAbs().maxCoeff();
}

}  // namespace ndg::test
