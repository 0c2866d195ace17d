// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/shell.h"

#include "ndg/elastic/projection.h"
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

/// Squared area of a wing's triangle over that of its rest, q, and the fade f(q) with its derivatives. q is a
/// polynomial of the vertices, so nothing is singular where the area vanishes.
struct Fade {
    double ratio = 1, value = 1, first = 0, second = 0;
    Eigen::Vector3d arm0, arm1, normal;  ///< of the triangle (x0, x1, wing)
    double scale = 1;                    ///< 1 / |rest normal|^2
    int wing_row = 6;                    ///< first row of the wing vertex among the hinge's 12

    Fade(const Hinge& hinge, const Vector3d& wing, double rest_area, int row) : wing_row(row)
    {
        arm0 = hinge.x1 - hinge.x0;
        arm1 = wing - hinge.x0;
        normal = arm0.cross(arm1);
        scale = 0.25 / (rest_area * rest_area);
        ratio = scale * normal.squaredNorm();
        constexpr double limit = bend_fade_share * bend_fade_share;
        if (ratio >= limit) return;
        const double s = ratio / limit;
        value = s * s * s * (10 + s * (6 * s - 15));
        first = 30 * s * s * (1 - s) * (1 - s) / limit;
        second = 60 * s * (1 - s) * (1 - 2 * s) / (limit * limit);
    }

    bool active() const { return value < 1; }

    Vector12 ratio_gradient() const
    {
        const Vector3d d_arm0 = 2 * scale * arm1.cross(normal), d_arm1 = 2 * scale * normal.cross(arm0);
        Vector12 gradient = Vector12::Zero();
        gradient.segment<3>(0) = -d_arm0 - d_arm1;
        gradient.segment<3>(3) = d_arm0;
        gradient.segment<3>(wing_row) = d_arm1;
        return gradient;
    }

    Matrix12 ratio_hessian() const
    {
        const Matrix3d n_arm0 = -cross_matrix(arm1), n_arm1 = cross_matrix(arm0);
        const Matrix3d block00 = 2 * scale * n_arm0.transpose() * n_arm0;
        const Matrix3d block11 = 2 * scale * n_arm1.transpose() * n_arm1;
        const Matrix3d block01 = 2 * scale * (n_arm0.transpose() * n_arm1 - cross_matrix(normal));
        Matrix12 hessian = Matrix12::Zero();
        hessian.block<3, 3>(3, 3) = block00;
        hessian.block<3, 3>(3, wing_row) = block01;
        hessian.block<3, 3>(wing_row, 3) = block01.transpose();
        hessian.block<3, 3>(wing_row, wing_row) = block11;
        for (const int row : {3, wing_row}) {
            hessian.block<3, 3>(row, 0) = -hessian.block<3, 3>(row, 3) - hessian.block<3, 3>(row, wing_row);
            hessian.block<3, 3>(0, row) = hessian.block<3, 3>(row, 0).transpose();
        }
        hessian.block<3, 3>(0, 0) = -hessian.block<3, 3>(3, 0) - hessian.block<3, 3>(wing_row, 0);
        return hessian;
    }
};

Fade left_fade(const Hinge& hinge, const HingeRest& rest)
{
    return {hinge, hinge.left, rest.left_area, 6};
}

Fade right_fade(const Hinge& hinge, const HingeRest& rest)
{
    return {hinge, hinge.right, rest.right_area, 9};
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

double bend_energy(const Hinge& hinge, const HingeRest& rest)
{
    const double fade = left_fade(hinge, rest).value * right_fade(hinge, rest).value;
    if (fade == 0) return 0;
    const double difference = angle_difference(hinge, rest.angle);
    return 0.5 * rest.weight * fade * difference * difference;
}

Vector12 bend_gradient(const Hinge& hinge, const HingeRest& rest)
{
    const Fade left = left_fade(hinge, rest), right = right_fade(hinge, rest);
    const double fade = left.value * right.value;
    if (fade == 0) return Vector12::Zero();
    const double difference = angle_difference(hinge, rest.angle);
    Vector12 gradient = rest.weight * fade * difference * dihedral_gradient(hinge);
    const double share = 0.5 * rest.weight * difference * difference;
    if (left.active()) gradient += share * right.value * left.first * left.ratio_gradient();
    if (right.active()) gradient += share * left.value * right.first * right.ratio_gradient();
    return gradient;
}

Matrix12 bend_hessian(const Hinge& hinge, const HingeRest& rest)
{
    const Fade left = left_fade(hinge, rest), right = right_fade(hinge, rest);
    const double fade = left.value * right.value;
    if (fade == 0) return Matrix12::Zero();
    const double difference = angle_difference(hinge, rest.angle);
    const Vector12 angle = dihedral_gradient(hinge);
    Matrix12 hessian = rest.weight * fade * (angle * angle.transpose() + difference * dihedral_hessian(hinge));
    if (!left.active() && !right.active()) return hessian;

    const Vector12 q_left = left.ratio_gradient(), q_right = right.ratio_gradient();
    const Vector12 fade_gradient = right.value * left.first * q_left + left.value * right.first * q_right;
    const Matrix12 across = left.first * right.first * q_left * q_right.transpose();
    const Matrix12 fade_hessian =
        right.value * (left.second * q_left * q_left.transpose() + left.first * left.ratio_hessian()) +
        left.value * (right.second * q_right * q_right.transpose() + right.first * right.ratio_hessian()) + across +
        across.transpose();
    const Matrix12 mixed = angle * fade_gradient.transpose();
    hessian += rest.weight * difference * (mixed + mixed.transpose() + 0.5 * difference * fade_hessian);
    return hessian;
}

double bend_stability(const Hinge& hinge, const HingeRest& rest)
{
    const Fade left = left_fade(hinge, rest), right = right_fade(hinge, rest);
    if (left.active() || right.active()) return -1e9;
    const double difference = angle_difference(hinge, rest.angle);
    const Vector12 angle = dihedral_gradient(hinge);
    return -std::abs(difference) * dihedral_hessian(hinge).norm() / angle.squaredNorm();
}

Matrix12 bend_gauss_newton_hessian(const Hinge& hinge, const HingeRest& rest)
{
    const double fade = left_fade(hinge, rest).value * right_fade(hinge, rest).value;
    if (fade == 0) return Matrix12::Zero();
    const Vector12 angle = dihedral_gradient(hinge);
    return rest.weight * fade * angle * angle.transpose();
}

Matrix12 bend_projected_hessian(const Hinge& hinge, const HingeRest& rest)
{
    // Translations cost nothing, so the eigenproblem is solved in an orthonormal basis of what is left, 9 of 12
    // dimensions: less than half the work.
    static const Eigen::Matrix<double, 12, 9> basis = [] {
        Eigen::Matrix<double, 4, 3> helmert;
        helmert << 1, 1, 1, -1, 1, 1, 0, -2, 1, 0, 0, -3;
        helmert.colwise().normalize();
        Eigen::Matrix<double, 12, 9> result = Eigen::Matrix<double, 12, 9>::Zero();
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b < 3; ++b) result.block<3, 3>(3 * a, 3 * b).diagonal().setConstant(helmert(a, b));
        }
        return result;
    }();
    const Matrix12 hessian = bend_hessian(hinge, rest);
    const Eigen::Matrix<double, 12, 9> half = hessian.lazyProduct(basis);
    const Eigen::Matrix<double, 9, 9> reduced = clamp_eigenvalues<9>(basis.transpose().lazyProduct(half));
    const Eigen::Matrix<double, 12, 9> back = basis.lazyProduct(reduced);
    return back.lazyProduct(basis.transpose());
}

}  // namespace ndg
