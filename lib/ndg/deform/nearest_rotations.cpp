// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/nearest_rotations.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <experimental/simd>

namespace ndg {

namespace {

constexpr int num_lanes = 8;
using Lanes = std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, num_lanes>>;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// For |F| = 1 the slope of the characteristic polynomial at its largest root is the product of the gaps to the other
/// roots. Below this, single precision tells neither root nor eigenvector well enough.
constexpr float ambiguous_below = 8e-3F;
constexpr int max_newton_steps = 16;
constexpr float newton_tolerance = 1e-7F;

/// Symmetric, K with tr(R^T F) = q^T K q for unit quaternions q = (w, x, y, z) of R.
struct QuaternionForm {
    Lanes ww, wx, wy, wz, xx, xy, xz, yy, yz, zz;
};

QuaternionForm quaternion_form(const std::array<Lanes, 9>& f)
{
    return {f[0] + f[4] + f[8], f[7] - f[5], f[2] - f[6],        f[3] - f[1], f[0] - f[4] - f[8],
            f[1] + f[3],        f[2] + f[6], f[4] - f[0] - f[8], f[5] + f[7], f[8] - f[0] - f[4]};
}

/// Of the form of F with |F| = 1: x^4 - 2 x^2 - 8 det(F) x + 2 |F^T F|^2 - 1 vanishes. `slope`: the polynomial's there.
Lanes largest_eigenvalue(const std::array<Lanes, 9>& f, Lanes& slope)
{
    const Lanes determinant =
        f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) + f[2] * (f[3] * f[7] - f[4] * f[6]);
    Lanes squared = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            const Lanes product = f[i] * f[j] + f[3 + i] * f[3 + j] + f[6 + i] * f[6 + j];
            squared += (i == j ? 1.0F : 2.0F) * product * product;
        }
    }
    const Lanes linear = 8.0F * determinant, constant = 2.0F * squared - 1.0F;
    // The sum of the singular values is at most sqrt(3) |F|.
    Lanes x = std::sqrt(3.0F);
    for (int step = 0; step < max_newton_steps; ++step) {
        const Lanes square = x * x;
        const Lanes value = (square - 2.0F) * square - linear * x + constant;
        slope = 4.0F * (square - 1.0F) * x - linear;
        Lanes change = value / slope;
        // Right of the root the polynomial is convex: the slope falls, and what is ambiguous here is so there.
        where(!(slope > ambiguous_below) || !(change > 0.0F), change) = 0.0F;
        x -= change;
        if (none_of(change > newton_tolerance)) break;
    }
    return x;
}

/// Unnormalised quaternions in the kernel of `form` - eigenvalue: the column of the adjugate with the largest diagonal
/// entry.
std::array<Lanes, 4> eigenvector(QuaternionForm k, const Lanes& eigenvalue)
{
    k.ww -= eigenvalue;
    k.xx -= eigenvalue;
    k.yy -= eigenvalue;
    k.zz -= eigenvalue;
    // Minors of rows y and z, then of rows w and x.
    const Lanes yz_yz = k.yy * k.zz - k.yz * k.yz, xz_yz = k.xy * k.zz - k.xz * k.yz, xy_yz = k.xy * k.yz - k.xz * k.yy;
    const Lanes wz_yz = k.wy * k.zz - k.wz * k.yz, wy_yz = k.wy * k.yz - k.wz * k.yy, wx_yz = k.wy * k.xz - k.wz * k.xy;
    const Lanes wx_wx = k.ww * k.xx - k.wx * k.wx, wy_wx = k.ww * k.xy - k.wy * k.wx, wz_wx = k.ww * k.xz - k.wz * k.wx;
    const Lanes xy_wx = k.wx * k.xy - k.wy * k.xx, xz_wx = k.wx * k.xz - k.wz * k.xx;
    const std::array<std::array<Lanes, 4>, 4> adjugate = [&] {
        const Lanes ww = k.xx * yz_yz - k.xy * xz_yz + k.xz * xy_yz;
        const Lanes wx = -(k.wx * yz_yz - k.xy * wz_yz + k.xz * wy_yz);
        const Lanes wy = k.wx * xz_yz - k.xx * wz_yz + k.xz * wx_yz;
        const Lanes wz = -(k.wx * xy_yz - k.xx * wy_yz + k.xy * wx_yz);
        const Lanes xx = k.ww * yz_yz - k.wy * wz_yz + k.wz * wy_yz;
        const Lanes xy = -(k.ww * xz_yz - k.wx * wz_yz + k.wz * wx_yz);
        const Lanes xz = k.ww * xy_yz - k.wx * wy_yz + k.wy * wx_yz;
        const Lanes yy = k.zz * wx_wx - k.xz * wz_wx + k.wz * xz_wx;
        const Lanes yz = -(k.yz * wx_wx - k.xz * wy_wx + k.wz * xy_wx);
        const Lanes zz = k.yy * wx_wx - k.xy * wy_wx + k.wy * xy_wx;
        return std::array<std::array<Lanes, 4>, 4>{
            {{ww, wx, wy, wz}, {wx, xx, xy, xz}, {wy, xy, yy, yz}, {wz, xz, yz, zz}}};
    }();
    std::array<Lanes, 4> vector = adjugate[0];
    Lanes size = abs(adjugate[0][0]);
    for (int c = 1; c < 4; ++c) {
        const Lanes diagonal = abs(adjugate[c][c]);
        const auto larger = diagonal > size;
        where(larger, size) = diagonal;
        for (int i = 0; i < 4; ++i) where(larger, vector[i]) = adjugate[c][i];
    }
    return vector;
}

/// Row-major, of quaternions (w, x, y, z) of any length but zero.
std::array<Lanes, 9> rotation_from(const std::array<Lanes, 4>& q)
{
    const auto& [w, x, y, z] = q;
    const Lanes s = 2.0F / (w * w + x * x + y * y + z * z);
    return {1.0F - s * (y * y + z * z), s * (x * y - w * z),        s * (x * z + w * y),
            s * (x * y + w * z),        1.0F - s * (x * x + z * z), s * (y * z - w * x),
            s * (x * z - w * y),        s * (y * z + w * x),        1.0F - s * (x * x + y * y)};
}

Matrix3 rotation_by_svd(const Matrix3& f)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(Eigen::Matrix3d(f), Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs[2] = -1;
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Gradients nearest_rotations(const Eigen::Ref<const Gradients>& gradients)
{
    const int count = int(gradients.rows());
    Gradients rotations(count, 9);
    for (int begin = 0; begin < count; begin += num_lanes) {
        const int used = std::min(num_lanes, count - begin);
        std::array<Lanes, 9> f;
        Lanes squared = 0;
        for (int k = 0; k < 9; ++k) {
            f[k] = Lanes([&](int lane) { return float(gradients(begin + std::min(lane, used - 1), k)); });
            squared += f[k] * f[k];
        }
        const Lanes scale = 1.0F / sqrt(squared);
        for (Lanes& entry : f) entry *= scale;
        Lanes slope;
        const Lanes eigenvalue = largest_eigenvalue(f, slope);
        const std::array<Lanes, 9> fitted = rotation_from(eigenvector(quaternion_form(f), eigenvalue));
        for (int lane = 0; lane < used; ++lane) {
            const int p = begin + lane;
            if (slope[lane] > ambiguous_below) {
                for (int k = 0; k < 9; ++k) rotations(p, k) = double(fitted[k][lane]);
            } else {
                Eigen::Map<Matrix3>(rotations.row(p).data()) =
                    rotation_by_svd(Eigen::Map<const Matrix3>(gradients.row(p).data()));
            }
        }
    }
    return rotations;
}

}  // namespace ndg
