// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/neo_hookean_lanes.h"

#include "ndg/elastic/neo_hookean.h"

#include <cmath>

namespace ndg {

namespace {

/// Second singular values below this share of the first leave the singular vectors to the general solver.
constexpr double line_share = 1e-5;

}  // namespace

NeoHookeanLanes::NeoHookeanLanes(const std::array<Lanes3, 3>& f, const std::array<const Lame*, num_lanes>& materials,
                                 const Lanes& weight)
    : f_(f), weight_(weight)
{
    mu_ = gather_lanes(materials, [](const Lame* lame) { return lame->mu; });
    lambda_ = gather_lanes(materials, [](const Lame* lame) { return lame->lambda; });
    cofactor_ = {cross(f_[1], f_[2]), cross(f_[2], f_[0]), cross(f_[0], f_[1])};
    // det F - 1 and mu/2 (|F|^2 - 3) - mu (det F - 1) by the invariants of H = F - I: in small strains nothing cancels.
    std::array<Lanes3, 3> h = f_;
    for (std::size_t i = 0; i < 3; ++i) h[i][i] -= 1.0;
    const Lanes minors = h[0][0] * h[1][1] - h[0][1] * h[1][0] + h[0][0] * h[2][2] - h[0][2] * h[2][0] +
                         h[1][1] * h[2][2] - h[1][2] * h[2][1];
    const Lanes determinant = dot(h[0], cross(h[1], h[2]));
    dilation_ = h[0][0] + h[1][1] + h[2][2] + minors + determinant;
    distortion_ = 0.5 * (dot(h[0], h[0]) + dot(h[1], h[1]) + dot(h[2], h[2])) - minors - determinant;
    pressure_ = lambda_ * dilation_ - mu_;
}

Lanes NeoHookeanLanes::energy() const
{
    return weight_ * (mu_ * distortion_ + 0.5 * lambda_ * dilation_ * dilation_);
}

std::array<Lanes3, 3> NeoHookeanLanes::stress() const
{
    std::array<Lanes3, 3> stress;
    for (std::size_t j = 0; j < 3; ++j) stress[j] = weight_ * (mu_ * f_[j] + pressure_ * cofactor_[j]);
    return stress;
}

Lanes NeoHookeanLanes::stability() const
{
    // Largest eigenvalue of F^T F: q + 2 p cos(acos(r) / 3) with mean q, deviator of norm p sqrt 6 (Smith 1961).
    const Lanes c00 = dot(f_[0], f_[0]), c11 = dot(f_[1], f_[1]), c22 = dot(f_[2], f_[2]);
    const Lanes c01 = dot(f_[0], f_[1]), c02 = dot(f_[0], f_[2]), c12 = dot(f_[1], f_[2]);
    const Lanes mean = (c00 + c11 + c22) / 3.0;
    const Lanes d0 = c00 - mean, d1 = c11 - mean, d2 = c22 - mean;
    const Lanes p = sqrt((d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * (c01 * c01 + c02 * c02 + c12 * c12)) / 6.0);
    const Lanes determinant = d0 * (d1 * d2 - c12 * c12) - c01 * (c01 * d2 - c12 * c02) + c02 * (c01 * c12 - d1 * c02);
    Lanes largest;
    for (std::size_t i = 0; i < num_lanes; ++i) {
        const double cubed = p[i] * p[i] * p[i];
        const double r = cubed > 0 ? std::min(std::max(0.5 * determinant[i] / cubed, -1.0), 1.0) : 1;
        largest[i] = mean[i] + 2 * p[i] * std::cos(std::acos(r) / 3);
    }
    return 1.0 - abs(pressure_) * sqrt(largest) / mu_;
}

template <std::size_t Corners>
void NeoHookeanLanes::hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const
{
    // B^T H B, where B takes the corners' coordinates to F: w (mu (g_a . g_b) I + lambda c_a c_b^T -
    // p [F (g_a x g_b)]), c_a = cof(F) g_a the gradient of det F, p = lambda (det F - 1) - mu, [.] the cross product
    // matrix.
    std::array<Lanes3, Corners> volume;
    for (std::size_t a = 0; a < Corners; ++a) {
        volume[a] = g[a][0] * cofactor_[0] + g[a][1] * cofactor_[1] + g[a][2] * cofactor_[2];
    }
    const Lanes stretch = weight_ * lambda_, twist = weight_ * pressure_, shear = weight_ * mu_;
    const std::array<Lanes3, 3> twisted{twist * f_[0], twist * f_[1], twist * f_[2]};
    for (std::size_t a = 0; a < Corners; ++a) {
        const Lanes3 scaled = stretch * volume[a];
        for (std::size_t b = 0; b <= a; ++b) {
            const std::size_t k = LaneBlocks<Corners>::at(a, b);
            const Lanes3 normal = cross(g[a], g[b]);
            const Lanes3 v = normal[0] * twisted[0] + normal[1] * twisted[1] + normal[2] * twisted[2];
            const Lanes diagonal = shear * dot(g[a], g[b]);
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
                blocks.set(k + 4 * i, scaled[i] * volume[b][i] + diagonal);
                blocks.set(k + next + 3 * last, scaled[next] * volume[b][last] + v[i]);
                blocks.set(k + last + 3 * next, scaled[last] * volume[b][next] - v[i]);
            }
        }
    }
}

template <std::size_t Corners>
void NeoHookeanLanes::projected_hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const
{
    hessian(g, blocks);
    // F V = U S with V, and then U, a rotation: the last singular value has the sign of det F.
    std::array<std::array<Lanes, 3>, 3> w{f_[0].c, f_[1].c, f_[2].c};
    std::array<Lanes3, 3> v{};
    for (std::size_t i = 0; i < 3; ++i) v[i] = {{i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}};
    orthogonalise<3>(w, &v);
    std::array<Lanes3, 3> u{{{w[0]}, {w[1]}, {w[2]}}};
    Lanes3 squared{{dot(u[0], u[0]), dot(u[1], u[1]), dot(u[2], u[2])}};
    // Turned round until the smallest is the last: its direction follows from the others.
    const auto turn = [&](const auto& lanes) {
        for (std::size_t c = 0; c < 3; ++c) {
            const auto turn_one = [&](Lanes& first, Lanes& second, Lanes& third) {
                const Lanes moved = first;
                where(lanes, first) = second;
                where(lanes, second) = third;
                where(lanes, third) = moved;
            };
            turn_one(u[0][c], u[1][c], u[2][c]);
            turn_one(v[0][c], v[1][c], v[2][c]);
            if (c == 0) turn_one(squared[0], squared[1], squared[2]);
        }
    };
    for (int i = 0; i < 2; ++i) turn(squared[2] > squared[0] || squared[2] > squared[1]);

    const Lanes s0 = sqrt(squared[0]), s1 = sqrt(squared[1]);
    const auto line = min(s0, s1) <= line_share * max(s0, s1);
    const Lanes3 third = u[2];
    u[0] = (1.0 / s0) * u[0];
    u[1] = (1.0 / s1) * u[1];
    u[2] = cross(u[0], u[1]);
    remove_negative(g, blocks, u, v, {{s0, s1, dot(u[2], third)}});
    if (!any_of(line)) return;
    for (std::size_t i = 0; i < num_lanes; ++i) {
        if (line[i]) replace_lane(g, blocks, i);
    }
}

template <std::size_t Corners>
void NeoHookeanLanes::remove_negative(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks,
                                      const std::array<Lanes3, 3>& u, const std::array<Lanes3, 3>& v,
                                      const Lanes3& s) const
{
    std::array<std::array<Lanes, Corners>, 3> turned;  // V^T G
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t a = 0; a < Corners; ++a) turned[i][a] = dot(v[i], g[a]);
    }
    // Twist and flip modes (u_j v_i^T -+ u_i v_j^T) / sqrt 2 with eigenvalues mu +- p s_k.
    std::array<Lanes3, Corners> mode, scaled;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        for (const double sign : {1.0, -1.0}) {
            const Lanes value = mu_ + sign * pressure_ * s[k];
            if (all_of(value >= 0.0)) continue;
            const Lanes excess = -0.5 * weight_ * min(value, Lanes(0.0));
            for (std::size_t a = 0; a < Corners; ++a) {
                mode[a] = turned[i][a] * u[j] - sign * turned[j][a] * u[i];
                scaled[a] = excess * mode[a];
            }
            blocks.add_products(scaled, mode);
        }
    }
    // The other three are combinations of the stretches u_i v_i^T.
    std::array<std::array<Lanes, 3>, 3> stretch;
    const Lanes3 areas{{s[1] * s[2], s[2] * s[0], s[0] * s[1]}};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        stretch[k][k] = mu_ + lambda_ * areas[k] * areas[k];
        stretch[i][j] = stretch[j][i] = lambda_ * areas[i] * areas[j] + pressure_ * s[k];
    }
    const Lanes minor = stretch[0][0] * stretch[1][1] - stretch[0][1] * stretch[0][1];
    const Lanes determinant = minor * stretch[2][2] +
                              stretch[0][2] * (stretch[0][1] * stretch[1][2] - stretch[1][1] * stretch[0][2]) -
                              stretch[1][2] * (stretch[0][0] * stretch[1][2] - stretch[0][1] * stretch[0][2]);
    const auto positive = minor > 0.0 && determinant > 0.0;
    if (all_of(positive)) return;
    // Minus the negative part of A is (|A| - A) / 2, and |A| = W S^-1 W^T where W = A V = U S.
    auto w = stretch;
    orthogonalise<3>(w);
    std::array<std::array<Lanes, 3>, 3> excess{};
    for (std::size_t k = 0; k < 3; ++k) {
        Lanes size = sqrt(w[k][0] * w[k][0] + w[k][1] * w[k][1] + w[k][2] * w[k][2]);
        where(size == 0.0, size) = 1.0;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) excess[i][j] += w[k][i] * w[k][j] / size;
        }
    }
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t a = 0; a < Corners; ++a) {
            mode[a] = turned[i][a] * u[i];
            scaled[a] = Lanes3{};
            for (std::size_t j = 0; j < 3; ++j) {
                Lanes share = 0.5 * weight_ * (excess[i][j] - stretch[i][j]);
                where(positive, share) = 0.0;
                scaled[a] = scaled[a] + (share * turned[j][a]) * u[j];
            }
        }
        blocks.add_products(scaled, mode);
    }
}

template <std::size_t Corners>
void NeoHookeanLanes::replace_lane(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks,
                                   std::size_t lane) const
{
    Eigen::Matrix3d f;
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) f(i, j) = f_[j][i][lane];
    }
    const Matrix9 modes = std::sqrt(double(weight_[lane])) * neo_hookean_projected_modes(f, {mu_[lane], lambda_[lane]});
    Eigen::Matrix<double, 3 * Corners, 9> rows;
    for (std::size_t a = 0; a < Corners; ++a) {
        rows.template middleRows<3>(3 * a) = double(g[a][0][lane]) * modes.topRows<3>() +
                                             double(g[a][1][lane]) * modes.middleRows<3>(3) +
                                             double(g[a][2][lane]) * modes.bottomRows<3>();
    }
    const Eigen::Matrix<double, 3 * Corners, 3 * Corners> full = rows.lazyProduct(rows.transpose());
    blocks.set_lane(lane, full);
}

template void NeoHookeanLanes::hessian(const std::array<Lanes3, 4>&, LaneBlocks<4>&) const;
template void NeoHookeanLanes::hessian(const std::array<Lanes3, 6>&, LaneBlocks<6>&) const;
template void NeoHookeanLanes::projected_hessian(const std::array<Lanes3, 4>&, LaneBlocks<4>&) const;
template void NeoHookeanLanes::projected_hessian(const std::array<Lanes3, 6>&, LaneBlocks<6>&) const;

}  // namespace ndg
