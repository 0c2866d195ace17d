// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/sphere.h"

#include "ndg/core/error.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <vector>

namespace ndg {

Sphere fit_sphere(const Eigen::Ref<const Points>& points)
{
    require(points.rows() >= 4, "a sphere needs 4 points, not {}", points.rows());
    const Eigen::RowVector3d middle = points.colwise().mean();
    const Points centred = points.rowwise() - middle;
    const Eigen::VectorXd squares = centred.rowwise().squaredNorm();
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
    Sphere sphere;
    constexpr int max_iterations = 60;
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
        // |x|^2 = 2 c.x + (r^2 - |c|^2) is linear in the centre c and one more unknown.
        Eigen::MatrixXd system(points.rows(), 4);
        system.leftCols<3>() = 2.0 * centred;
        system.col(3).setOnes();
        const Eigen::VectorXd roots = weights.cwiseSqrt();
        const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(roots.asDiagonal() * system);
        require(solver.rank() == 4, "the {} points of a sphere lie in a plane", points.rows());
        const Eigen::Vector4d solution = solver.solve(roots.cwiseProduct(squares));
        const Eigen::Vector3d centre = solution.head<3>();
        const Eigen::Vector3d moved = sphere.centre - centre;
        sphere.centre = centre;
        sphere.radius = std::sqrt(std::max(0.0, solution[3] + centre.squaredNorm()));
        if (iteration > 0 && moved.norm() < 1e-9 * (sphere.radius + 1e-9)) break;
        Eigen::VectorXd errors(points.rows());
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            errors[i] = std::abs((centred.row(i).transpose() - centre).norm() - sphere.radius);
        std::vector<double> sorted(errors.data(), errors.data() + errors.size());
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        // 4.685 standard deviations, 1.4826 median deviations each: 95 % efficiency for normal errors (Tukey).
        const double cut = std::max(4.685 * 1.4826 * sorted[sorted.size() / 2], 1e-6 * sphere.radius);
        for (Eigen::Index i = 0; i < points.rows(); ++i) {
            const double ratio = std::min(1.0, errors[i] / cut);
            weights[i] = std::pow(1.0 - ratio * ratio, 2);
        }
    }
    sphere.centre += middle.transpose();
    return sphere;
}

}  // namespace ndg
