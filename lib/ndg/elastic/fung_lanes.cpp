// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/fung_lanes.h"

#include <cmath>
#include <limits>

namespace ndg {

namespace {

/// Share of the stiffness that rounding alone may take from the bound of the eigenvalues.
constexpr double bound_rounding = 1e-12;

/// function(x) of every lane.
template <class Function>
Lanes each_lane(const Lanes& x, const Function& function)
{
    Lanes result;
    for (std::size_t i = 0; i < num_lanes; ++i) result[i] = function(double(x[i]));
    return result;
}

}  // namespace

FungLanes::FungLanes(const std::array<Lanes3, 3>& f, const std::array<const OrthotropicMaterial*, num_lanes>& materials,
                     const Lanes& weight)
    : weight_(weight)
{
    mu_ = gather_lanes(materials, [](const OrthotropicMaterial* m) { return m->mu; });
    lambda_ = gather_lanes(materials, [](const OrthotropicMaterial* m) { return m->lambda; });
    saturation_ = gather_lanes(materials, [](const OrthotropicMaterial* m) { return m->saturation; });
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t k = i + 3 * j;
            basis_[j][i] = gather_lanes(materials, [&](const OrthotropicMaterial* m) { return m->basis.data()[k]; });
            tau_[i][j] = gather_lanes(materials, [&](const OrthotropicMaterial* m) { return m->weights.data()[k]; });
        }
    }
    // By H = F - I: in small strains nothing cancels.
    std::array<Lanes3, 3> h = f, turned;
    for (std::size_t i = 0; i < 3; ++i) h[i][i] -= 1.0;
    for (std::size_t j = 0; j < 3; ++j) {
        turned[j] = basis_[j][0] * h[0] + basis_[j][1] * h[1] + basis_[j][2] * h[2];
        f_[j] = basis_[j] + turned[j];
    }
    cofactor_ = {cross(f_[1], f_[2]), cross(f_[2], f_[0]), cross(f_[0], f_[1])};
    const Lanes minors = h[0][0] * h[1][1] - h[0][1] * h[1][0] + h[0][0] * h[2][2] - h[0][2] * h[2][0] +
                         h[1][1] * h[2][2] - h[1][2] * h[2][1];
    dilation_ = h[0][0] + h[1][1] + h[2][2] + minors + dot(h[0], cross(h[1], h[2]));
    Lanes sigma = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            const Lanes strain =
                0.5 * (dot(basis_[i], turned[j]) + dot(turned[i], basis_[j]) + dot(turned[i], turned[j]));
            tension_[i][j] = tension_[j][i] = 2.0 * tau_[i][j] * strain;
            sigma += (i == j ? 0.5 : 1.0) * tension_[i][j] * strain;
        }
    }
    exponent_ = saturation_ * sigma;
    growth_ =
        mu_ * each_lane(exponent_, [](double x) { return std::exp(x <= largest_exponent ? x : largest_exponent); });
}

Lanes FungLanes::energy() const
{
    Lanes energy = weight_ * (mu_ / saturation_ * each_lane(exponent_, [](double x) { return std::expm1(x); }) +
                              0.5 * lambda_ * dilation_ * dilation_);
    where(!(exponent_ <= largest_exponent), energy) = std::numeric_limits<double>::infinity();
    return energy;
}

std::array<Lanes3, 3> FungLanes::stress() const
{
    std::array<Lanes3, 3> turned, stress;  // turned: by the axes of the basis
    const Lanes pull = weight_ * growth_, push = weight_ * lambda_ * dilation_;
    for (std::size_t j = 0; j < 3; ++j) {
        turned[j] =
            pull * (tension_[0][j] * f_[0] + tension_[1][j] * f_[1] + tension_[2][j] * f_[2]) + push * cofactor_[j];
    }
    for (std::size_t i = 0; i < 3; ++i) {
        stress[i] = basis_[0][i] * turned[0] + basis_[1][i] * turned[1] + basis_[2][i] * turned[2];
    }
    return stress;
}

Lanes FungLanes::stability() const
{
    // Stress adds eigenvalues of the tensions (Gershgorin's circles), pressure those of the Hessian of det F, at most
    // sqrt 2 |F|.
    Lanes least = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        least = min(least, tension_[i][i] - abs(tension_[i][j]) - abs(tension_[i][k]));
    }
    const Lanes size = sqrt(2.0 * (dot(f_[0], f_[0]) + dot(f_[1], f_[1]) + dot(f_[2], f_[2])));
    return least - lambda_ * abs(dilation_) * size / growth_;
}

template <std::size_t Corners>
std::array<Lanes3, Corners> FungLanes::in_basis(const std::array<Lanes3, Corners>& g) const
{
    std::array<Lanes3, Corners> turned;
    for (std::size_t a = 0; a < Corners; ++a) {
        for (std::size_t i = 0; i < 3; ++i) turned[a][i] = dot(basis_[i], g[a]);
    }
    return turned;
}

template <std::size_t Corners>
void FungLanes::hessian_in_basis(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const
{
    // With f_i the columns of F B, A the tensions, A_ij = 2 tau_ij E'_ij, and w = mu exp(eta sigma), blocks are
    //   w sum_ij M_ij f_i f_j^T + w (g_a . A g_b) I + lambda c_a c_b^T + lambda (det F - 1) d^2 det F,
    //   M_ij = eta (A g_a)_i (A g_b)_j + tau_ij (g_a)_j (g_b)_i + [i = j] sum_k tau_ik (g_a)_k (g_b)_k.
    std::array<Lanes3, Corners> pulled, volume;
    for (std::size_t a = 0; a < Corners; ++a) {
        for (std::size_t i = 0; i < 3; ++i) {
            pulled[a][i] = tension_[i][0] * g[a][0] + tension_[i][1] * g[a][1] + tension_[i][2] * g[a][2];
        }
        volume[a] = g[a][0] * cofactor_[0] + g[a][1] * cofactor_[1] + g[a][2] * cofactor_[2];
    }
    const Lanes grown = weight_ * growth_, stretch = weight_ * lambda_, twist = stretch * dilation_;
    const std::array<Lanes3, 3> twisted{twist * f_[0], twist * f_[1], twist * f_[2]};
    const std::array<Lanes3, 3> scaled{grown * f_[0], grown * f_[1], grown * f_[2]};
    for (std::size_t a = 0; a < Corners; ++a) {
        const Lanes3 scaled_volume = stretch * volume[a], saturated = saturation_ * pulled[a];
        for (std::size_t b = 0; b <= a; ++b) {
            const std::size_t at = LaneBlocks<Corners>::at(a, b);
            const Lanes3 common{{g[a][0] * g[b][0], g[a][1] * g[b][1], g[a][2] * g[b][2]}};
            std::array<Lanes3, 3> right;  // sum_j M_ij f_j
            for (std::size_t i = 0; i < 3; ++i) {
                Lanes3 m;
                for (std::size_t j = 0; j < 3; ++j) {
                    m[j] = saturated[i] * pulled[b][j] + tau_[i][j] * g[a][j] * g[b][i];
                }
                m[i] += tau_[i][0] * common[0] + tau_[i][1] * common[1] + tau_[i][2] * common[2];
                right[i] = m[0] * f_[0] + m[1] * f_[1] + m[2] * f_[2];
            }
            const Lanes diagonal = grown * dot(pulled[a], g[b]);
            std::array<Lanes3, 3> block;  // rows
            for (std::size_t r = 0; r < 3; ++r) {
                block[r] = scaled[0][r] * right[0] + scaled[1][r] * right[1] + scaled[2][r] * right[2] +
                           scaled_volume[r] * volume[b];
                block[r][r] += diagonal;
            }
            const Lanes3 normal = cross(g[a], g[b]);
            const Lanes3 v = normal[0] * twisted[0] + normal[1] * twisted[1] + normal[2] * twisted[2];
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
                block[next][last] += v[i];
                block[last][next] -= v[i];
            }
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t r = 0; r < 3; ++r) blocks.set(at + r + 3 * c, block[r][c]);
            }
        }
    }
}

template <std::size_t Corners>
void FungLanes::hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const
{
    hessian_in_basis(in_basis(g), blocks);
}

template <std::size_t Corners>
void FungLanes::projected_hessian(const std::array<Lanes3, Corners>& g, LaneBlocks<Corners>& blocks) const
{
    const auto semidefinite = stability() >= -bound_rounding;
    if (all_of(semidefinite)) return hessian(g, blocks);
    // d^2 psi / d F^2 by the columns of F B, and minus its negative part: (|A| - A) / 2, where |A| = W S^-1 W^T,
    // W = A V = U S.
    std::array<Lanes3, 3> unit;
    for (std::size_t i = 0; i < 3; ++i) unit[i] = {{i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}};
    LaneBlocks<3> lower;
    hessian_in_basis(unit, lower);
    std::array<std::array<Lanes, 9>, 9> a, w;
    for (std::size_t row = 0; row < 9; ++row) {
        for (std::size_t column = 0; column <= row; ++column) {
            a[row][column] = a[column][row] =
                lower.get(LaneBlocks<3>::at(row / 3, column / 3) + row % 3 + 3 * (column % 3));
        }
    }
    w = a;
    orthogonalise<9>(w);
    for (auto& column : w) {
        Lanes squared = 0.0;
        for (const Lanes& entry : column) squared += entry * entry;
        Lanes root = sqrt(sqrt(squared));
        where(root == 0.0, root) = 1.0;
        for (Lanes& entry : column) entry /= root;
    }
    for (std::size_t row = 0; row < 9; ++row) {
        for (std::size_t column = 0; column <= row; ++column) {
            Lanes absolute = 0.0;
            for (const auto& mode : w) absolute += mode[row] * mode[column];
            Lanes excess = 0.5 * (absolute - a[row][column]);
            where(semidefinite, excess) = 0.0;
            const Lanes value = a[row][column] + excess;
            a[row][column] = a[column][row] = value;
        }
    }
    const std::array<Lanes3, Corners> turned = in_basis(g);
    for (std::size_t p = 0; p < Corners; ++p) {
        std::array<std::array<Lanes, 9>, 3> left;  // of corner p: rows by coordinate, columns by those of F B
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t k = 0; k < 9; ++k) {
                left[r][k] = turned[p][0] * a[r][k] + turned[p][1] * a[3 + r][k] + turned[p][2] * a[6 + r][k];
            }
        }
        for (std::size_t q = 0; q <= p; ++q) {
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t r = 0; r < 3; ++r) {
                    blocks.set(
                        LaneBlocks<Corners>::at(p, q) + r + 3 * c,
                        turned[q][0] * left[r][c] + turned[q][1] * left[r][3 + c] + turned[q][2] * left[r][6 + c]);
                }
            }
        }
    }
}

template void FungLanes::hessian(const std::array<Lanes3, 4>&, LaneBlocks<4>&) const;
template void FungLanes::hessian(const std::array<Lanes3, 6>&, LaneBlocks<6>&) const;
template void FungLanes::projected_hessian(const std::array<Lanes3, 4>&, LaneBlocks<4>&) const;
template void FungLanes::projected_hessian(const std::array<Lanes3, 6>&, LaneBlocks<6>&) const;

}  // namespace ndg
