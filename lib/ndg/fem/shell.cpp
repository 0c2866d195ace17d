// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/shell.h"

#include "ndg/fem/projection.h"
#include "ndg/geometry/triangle_mesh.h"

#include <Eigen/Geometry>

#include <cmath>

namespace ndg {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double pi = 3.14159265358979323846;

Matrix3d cross_matrix(const Vector3d& v)
{
    Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

/// Spring block B of the Hessian [B, -B; -B, B].
Matrix3d spring_block(const Vector3d& x0, const Vector3d& x1, double rest_length, bool projected)
{
    const Vector3d edge = x1 - x0;
    const double length = edge.norm();
    const Vector3d direction = edge / length;
    double across = 1 - rest_length / length;
    if (projected) across = std::max(across, 0.0);
    const Matrix3d along = direction * direction.transpose();
    return (along + across * (Matrix3d::Identity() - along)) / (rest_length * rest_length);
}

Matrix6 spring_hessian(const Matrix3d& block)
{
    Matrix6 hessian;
    hessian << block, -block, -block, block;
    return hessian;
}

/// One side of a hinge. The angle's gradient is u (1 - t) on x0, u t on x1 and -u on the wing vertex, where u is the
/// side's normal divided by the wing's height and t the foot of the wing vertex along the edge.
struct Wing {
    Vector3d edge, arm, normal, u;
    double length = 0, t = 0, side = 1;

    Wing(const Vector3d& x0, const Vector3d& x1, const Vector3d& wing, double side_sign)
        : edge(x1 - x0), arm(wing - x0), side(side_sign)
    {
        length = edge.norm();
        normal = side * edge.cross(arm);
        u = normal * (length / normal.squaredNorm());
        t = arm.dot(edge) / (length * length);
    }

    /// Derivative of the gradient with respect to (x0, x1, wing), 9 x 9. Not symmetric by itself: only the sum of both
    /// sides is.
    Eigen::Matrix<double, 9, 9> derivative() const
    {
        const double area2 = normal.squaredNorm();
        const Matrix3d u_normal = (length / area2) * (Matrix3d::Identity() - 2 * normal * normal.transpose() / area2);
        const Matrix3d u_edge = normal * edge.transpose() / (length * area2) - side * u_normal * cross_matrix(arm);
        const Matrix3d u_arm = side * u_normal * cross_matrix(edge);
        const Vector3d t_edge = (arm - 2 * t * edge) / (length * length);
        const Vector3d t_arm = edge / (length * length);

        Matrix3d u_vertex[3] = {-u_edge - u_arm, u_edge, u_arm};
        Vector3d t_vertex[3] = {-t_edge - t_arm, t_edge, t_arm};
        Eigen::Matrix<double, 9, 9> result;
        for (int k = 0; k < 3; ++k) {
            const Matrix3d shift = u * t_vertex[k].transpose();
            result.block<3, 3>(0, 3 * k) = (1 - t) * u_vertex[k] - shift;
            result.block<3, 3>(3, 3 * k) = t * u_vertex[k] + shift;
            result.block<3, 3>(6, 3 * k) = -u_vertex[k];
        }
        return result;
    }
};

double angle_difference(const Hinge& hinge, double rest_angle)
{
    const double difference = dihedral_angle(hinge.x0, hinge.x1, hinge.left, hinge.right) - rest_angle;
    return difference - 2 * pi * std::ceil((difference - pi) / (2 * pi));
}

}  // namespace

double stretch_energy(const Vector3d& x0, const Vector3d& x1, double rest_length)
{
    const double strain = (x1 - x0).norm() / rest_length - 1;
    return 0.5 * strain * strain;
}

Vector6 stretch_gradient(const Vector3d& x0, const Vector3d& x1, double rest_length)
{
    const Vector3d edge = x1 - x0;
    const double length = edge.norm();
    const Vector3d pull = edge * ((length - rest_length) / (length * rest_length * rest_length));
    Vector6 gradient;
    gradient.head<3>() = -pull;
    gradient.tail<3>() = pull;
    return gradient;
}

Matrix6 stretch_hessian(const Vector3d& x0, const Vector3d& x1, double rest_length)
{
    return spring_hessian(spring_block(x0, x1, rest_length, false));
}

Matrix6 stretch_projected_hessian(const Vector3d& x0, const Vector3d& x1, double rest_length)
{
    return spring_hessian(spring_block(x0, x1, rest_length, true));
}

Vector12 dihedral_gradient(const Hinge& hinge)
{
    const Wing left(hinge.x0, hinge.x1, hinge.left, 1), right(hinge.x0, hinge.x1, hinge.right, -1);
    Vector12 gradient;
    gradient << (1 - left.t) * left.u + (1 - right.t) * right.u, left.t * left.u + right.t * right.u, -left.u, -right.u;
    return gradient;
}

Matrix12 dihedral_hessian(const Hinge& hinge)
{
    const auto left = Wing(hinge.x0, hinge.x1, hinge.left, 1).derivative();
    const auto right = Wing(hinge.x0, hinge.x1, hinge.right, -1).derivative();
    Matrix12 hessian = Matrix12::Zero();
    hessian.topLeftCorner<9, 9>() = left;
    const int rows[3] = {0, 3, 9};
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
            hessian.block<3, 3>(rows[a], rows[b]) += right.block<3, 3>(3 * a, 3 * b);
        }
    }
    return 0.5 * (hessian + hessian.transpose());
}

double bend_energy(const Hinge& hinge, double rest_angle, double weight)
{
    const double difference = angle_difference(hinge, rest_angle);
    return 0.5 * weight * difference * difference;
}

Vector12 bend_gradient(const Hinge& hinge, double rest_angle, double weight)
{
    return weight * angle_difference(hinge, rest_angle) * dihedral_gradient(hinge);
}

Matrix12 bend_hessian(const Hinge& hinge, double rest_angle, double weight)
{
    const Vector12 gradient = dihedral_gradient(hinge);
    return weight * (gradient * gradient.transpose() + angle_difference(hinge, rest_angle) * dihedral_hessian(hinge));
}

Matrix12 bend_projected_hessian(const Hinge& hinge, double rest_angle, double weight)
{
    return clamp_eigenvalues<12>(bend_hessian(hinge, rest_angle, weight));
}

}  // namespace ndg
