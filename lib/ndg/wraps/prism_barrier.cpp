// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/prism_barrier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ndg {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The three columns of the Jacobian at one point as weights of the six vertices.
struct JacobianPoint {
    Eigen::Matrix<double, 3, 6> columns;
    bool corner;
};

/// Six corners, then the two quadrature points of the prism element (geometry/prism.h).
const std::array<JacobianPoint, 8>& jacobian_points()
{
    static const std::array<JacobianPoint, 8> points = [] {
        std::array<JacobianPoint, 8> list;
        const auto set = [](JacobianPoint& point, double xi, const Eigen::Vector3d& at) {
            point.columns << xi, 0, -xi, 1 - xi, 0, xi - 1,  //
                0, xi, -xi, 0, 1 - xi, xi - 1,               //
                at[0], at[1], at[2], -at[0], -at[1], -at[2];
        };
        for (int k = 0; k < 3; ++k) {
            set(list[k], 1.0, Eigen::Vector3d::Unit(k));
            set(list[3 + k], 0.0, Eigen::Vector3d::Unit(k));
        }
        const double offset = 0.5 / std::sqrt(3.0);
        set(list[6], 0.5 - offset, Eigen::Vector3d::Constant(1.0 / 3.0));
        set(list[7], 0.5 + offset, Eigen::Vector3d::Constant(1.0 / 3.0));
        for (std::size_t p = 0; p < 8; ++p) list[p].corner = p < 6;
        return list;
    }();
    return points;
}

/// Scaled Jacobian and height at one point, with their derivatives by the columns of J.
struct Quality {
    double jacobian, height;
    Eigen::Matrix3d jacobian_gradient, height_gradient;  ///< row c: by column c of J
};

Quality point_quality(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, const Eigen::RowVector3d& c,
                      bool with_gradient)
{
    static const double ideal = std::sqrt(3.0) / 2.0;
    Quality quality;
    const Eigen::RowVector3d normal = a.cross(b);
    const double la = a.norm(), lb = b.norm(), lc = c.norm(), area = normal.norm();
    const double scale = la * lb * lc * ideal;
    if (!(scale > 0.0) || !(area > 0.0)) return {0.0, 0.0, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
    const double det = normal.dot(c);
    quality.jacobian = det / scale;
    quality.height = det / area;
    if (!with_gradient) return quality;
    const Eigen::RowVector3d bc = b.cross(c), ca = c.cross(a), unit = normal / area;
    quality.jacobian_gradient.row(0) = bc / scale - quality.jacobian / (la * la) * a;
    quality.jacobian_gradient.row(1) = ca / scale - quality.jacobian / (lb * lb) * b;
    quality.jacobian_gradient.row(2) = normal / scale - quality.jacobian / (lc * lc) * c;
    quality.height_gradient.row(0) = (bc - quality.height * b.cross(unit)) / area;
    quality.height_gradient.row(1) = (ca - quality.height * unit.cross(a)) / area;
    quality.height_gradient.row(2) = unit;
    return quality;
}

/// -(1 - y)^2 log y with y running from 0 at the bound to 1 at `active`; zero beyond.
double barrier(double value, double bound, double active, double& derivative, double* curvature = nullptr)
{
    derivative = 0.0;
    if (curvature != nullptr) *curvature = 0.0;
    if (value >= active) return 0.0;
    if (!(value > bound)) return infinity;
    const double width = active - bound;
    const double y = (value - bound) / width;
    derivative = (2.0 * (1.0 - y) * std::log(y) - (1.0 - y) * (1.0 - y) / y) / width;
    if (curvature != nullptr)
        *curvature = (-2.0 * std::log(y) + 4.0 * (1.0 - y) / y + (1.0 - y) * (1.0 - y) / (y * y)) / (width * width);
    return -(1.0 - y) * (1.0 - y) * std::log(y);
}

}  // namespace

namespace {

/// Sum of two terms over a prism: `jacobian_term(value, derivative, curvature)` of the scaled Jacobians and
/// `height_term` of the heights. Adds to gradient and Hessian as prism_barrier says.
template <typename JacobianTerm, typename HeightTerm>
double add_quality_terms(const PrismVertices& prism, const JacobianTerm& jacobian_term, const HeightTerm& height_term,
                         PrismVertices* gradient, Eigen::Matrix<double, 18, 18>* hessian)
{
    double energy = 0.0;
    const bool derive = gradient != nullptr || hessian != nullptr;
    for (const JacobianPoint& point : jacobian_points()) {
        const Eigen::Matrix3d columns = point.columns * prism;
        const Quality quality = point_quality(columns.row(0), columns.row(1), columns.row(2), derive);
        double by_jacobian = 0.0, by_height = 0.0, jacobian_curvature = 0.0, height_curvature = 0.0;
        energy += jacobian_term(quality.jacobian, by_jacobian, jacobian_curvature);
        if (point.corner) energy += height_term(quality.height, by_height, height_curvature);
        if (!std::isfinite(energy)) return infinity;
        if (!derive || (by_jacobian == 0.0 && by_height == 0.0)) continue;
        const PrismVertices jacobian_slope = point.columns.transpose() * quality.jacobian_gradient;
        const PrismVertices height_slope = point.columns.transpose() * quality.height_gradient;
        if (gradient != nullptr) *gradient += by_jacobian * jacobian_slope + by_height * height_slope;
        if (hessian == nullptr) continue;
        using Vector18 = Eigen::Matrix<double, 18, 1>;
        const Eigen::Matrix<double, 6, 3, Eigen::RowMajor> a = jacobian_slope, b = height_slope;
        const Vector18 u = Eigen::Map<const Vector18>(a.data()), w = Eigen::Map<const Vector18>(b.data());
        *hessian += jacobian_curvature * u * u.transpose() + height_curvature * w * w.transpose();
        for (int c = 0; c < 3; ++c) {
            const double squared = columns.row(c).squaredNorm();
            if (!(squared > 0.0)) continue;
            const double bound = 0.5 * std::abs(by_jacobian) / squared;
            for (int i = 0; i < 6; ++i)
                for (int j = 0; j < 6; ++j)
                    hessian->block<3, 3>(3 * i, 3 * j).diagonal().array() +=
                        bound * point.columns(c, i) * point.columns(c, j);
        }
    }
    return energy;
}

/// (1 - value / active)^2 below `active`, zero beyond.
double hinge(double value, double active, double& derivative, double& curvature)
{
    derivative = curvature = 0.0;
    if (value >= active) return 0.0;
    const double y = 1.0 - value / active;
    derivative = -2.0 * y / active;
    curvature = 2.0 / (active * active);
    return y * y;
}

}  // namespace

double prism_penalty(const PrismVertices& prism, double active_jacobian, double active_thickness,
                     PrismVertices* gradient, Eigen::Matrix<double, 18, 18>* hessian)
{
    return add_quality_terms(
        prism,
        [&](double value, double& derivative, double& curvature) {
            return hinge(value, active_jacobian, derivative, curvature);
        },
        [&](double value, double& derivative, double& curvature) {
            return hinge(value, active_thickness, derivative, curvature);
        },
        gradient, hessian);
}

double prism_barrier(const PrismVertices& prism, const BarrierBounds& bounds, PrismVertices* gradient,
                     Eigen::Matrix<double, 18, 18>* hessian)
{
    double energy = add_quality_terms(
        prism,
        [&](double value, double& derivative, double& curvature) {
            return barrier(value, bounds.jacobian, bounds.active_jacobian, derivative, &curvature);
        },
        [&](double value, double& derivative, double& curvature) {
            return barrier(value, bounds.thickness, bounds.active_thickness, derivative, &curvature);
        },
        gradient, hessian);
    if (!std::isfinite(energy)) return infinity;
    const bool derive = gradient != nullptr || hessian != nullptr;
    const Eigen::RowVector3d a = prism.row(3) - prism.row(5), b = prism.row(4) - prism.row(5);
    const Eigen::RowVector3d normal = a.cross(b);
    const double area = normal.norm();
    double by_area = 0.0, curvature = 0.0;
    energy += barrier(area, bounds.area, bounds.active_area, by_area, &curvature);
    if (!derive || by_area == 0.0 || !std::isfinite(energy)) return energy;
    PrismVertices slope = PrismVertices::Zero();
    slope.row(3) = b.cross(normal) / area;
    slope.row(4) = normal.cross(a) / area;
    slope.row(5) = -slope.row(3) - slope.row(4);
    if (gradient != nullptr) *gradient += by_area * slope;
    if (hessian == nullptr) return energy;
    const Eigen::Matrix<double, 6, 3, Eigen::RowMajor> flat = slope;
    const auto u = Eigen::Map<const Eigen::Matrix<double, 18, 1>>(flat.data());
    *hessian += curvature * u * u.transpose();
    return energy;
}

Eigen::RowVector3d prism_quality(const PrismVertices& prism)
{
    Eigen::RowVector3d smallest(infinity, infinity, infinity);
    for (const JacobianPoint& point : jacobian_points()) {
        const Eigen::Matrix3d columns = point.columns * prism;
        const Quality quality = point_quality(columns.row(0), columns.row(1), columns.row(2), false);
        smallest[0] = std::min(smallest[0], quality.jacobian);
        if (point.corner) smallest[1] = std::min(smallest[1], quality.height);
    }
    smallest[2] = (prism.row(3) - prism.row(5)).cross(prism.row(4) - prism.row(5)).norm();
    return smallest;
}

}  // namespace ndg
