// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/corotated_term.h"

#include "ndg/core/error.h"
#include "ndg/elastic/elements.h"

namespace ndg {

CorotatedLanes::CorotatedLanes(const Points& positions, const Batch& batch)
    : batch_(batch),
      weight_(gather_lanes(batch.rests, [](const Rest* rest) { return rest->weight / num_corners; })),
      mu_(gather_lanes(batch.rests, [](const Rest* rest) { return rest->material.mu; })),
      lambda_(gather_lanes(batch.rests, [](const Rest* rest) { return rest->material.lambda; }))
{
    for (std::size_t a = 0; a < num_corners; ++a) {
        for (std::size_t c = 0; c < 3; ++c)
            g_[a][c] = gather_lanes(batch.rests, [&](const Rest* rest) { return rest->gradient.data()[3 * a + c]; });
    }
    // The columns of G sum to zero; differences keep the digits that a body's distance from the origin costs.
    const std::array<Lanes3, num_corners> x = gather_corners<num_corners>(positions, batch.corners);
    for (std::size_t j = 0; j < 3; ++j) {
        f_[j] = g_[0][j] * (x[0] - x[5]);
        for (std::size_t a = 1; a < 5; ++a) f_[j] = f_[j] + g_[a][j] * (x[a] - x[5]);
    }
}

CorotatedLanes::LaneMatrix CorotatedLanes::rotation(std::size_t corner) const
{
    LaneMatrix columns;
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) {
            columns[j][i] = gather_lanes(batch_.rests,
                                         [&](const Rest* rest) { return rest->rotations[corner]->data()[3 * j + i]; });
        }
    }
    return columns;
}

CorotatedLanes::LaneMatrix CorotatedLanes::strain(const LaneMatrix& rotation) const
{
    LaneMatrix strain;
    for (std::size_t i = 0; i < 3; ++i) {
        strain[i][i] = dot(rotation[i], f_[i]) - 1.0;
        for (std::size_t j = 0; j < i; ++j)
            strain[i][j] = strain[j][i] = 0.5 * (dot(rotation[i], f_[j]) + dot(rotation[j], f_[i]));
    }
    return strain;
}

Lanes CorotatedLanes::energy() const
{
    Lanes sum = 0.0;
    for (std::size_t corner = 0; corner < num_corners; ++corner) {
        const LaneMatrix e = strain(rotation(corner));
        const Lanes trace = e[0][0] + e[1][1] + e[2][2];
        sum += 0.5 * lambda_ * trace * trace + mu_ * (dot(e[0], e[0]) + dot(e[1], e[1]) + dot(e[2], e[2]));
    }
    return weight_ * sum;
}

std::tuple<LaneVector<3 * CorotatedLanes::num_corners>> CorotatedLanes::forces() const
{
    // d psi / d F = R sigma with sigma = 2 mu eps + lambda tr(eps) I.
    LaneMatrix stress;
    for (Lanes3& column : stress) column = {{Lanes(0.0), Lanes(0.0), Lanes(0.0)}};
    for (std::size_t corner = 0; corner < num_corners; ++corner) {
        const LaneMatrix r = rotation(corner), e = strain(r);
        const Lanes pressure = lambda_ * (e[0][0] + e[1][1] + e[2][2]);
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i)
                stress[j] = stress[j] + (2.0 * mu_ * e[j][i] + (i == j ? pressure : Lanes(0.0))) * r[i];
        }
    }
    std::tuple<LaneVector<3 * num_corners>> result;
    for (std::size_t a = 0; a < num_corners; ++a) {
        std::get<0>(result).set3(a, weight_ * (g_[a][0] * stress[0] + g_[a][1] * stress[1] + g_[a][2] * stress[2]));
    }
    return result;
}

void CorotatedLanes::hessian(LaneBlocks<num_corners>& blocks) const
{
    // Block (a, b) of a corner, h = R g: lambda h_a h_b^T + mu h_b h_a^T + mu (g_a . g_b) I.
    for (std::size_t a = 0; a < num_corners; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            const Lanes isotropic = double(num_corners) * weight_ * mu_ * dot(g_[a], g_[b]);
            for (std::size_t k = 0; k < 9; ++k) blocks.set(blocks.at(a, b) + k, k % 4 == 0 ? isotropic : Lanes(0.0));
        }
    }
    for (std::size_t corner = 0; corner < num_corners; ++corner) {
        const LaneMatrix r = rotation(corner);
        std::array<Lanes3, num_corners> h;
        for (std::size_t a = 0; a < num_corners; ++a) h[a] = g_[a][0] * r[0] + g_[a][1] * r[1] + g_[a][2] * r[2];
        const Lanes mu = weight_ * mu_, lambda = weight_ * lambda_;
        for (std::size_t a = 0; a < num_corners; ++a) {
            const Lanes3 mu_h = mu * h[a], lambda_h = lambda * h[a];
            for (std::size_t b = 0; b <= a; ++b) {
                for (std::size_t j = 0; j < 3; ++j) {
                    for (std::size_t i = 0; i < 3; ++i) {
                        const std::size_t k = blocks.at(a, b) + i + 3 * j;
                        blocks.set(k, blocks.get(k) + lambda_h[i] * h[b][j] + mu_h[j] * h[b][i]);
                    }
                }
            }
        }
    }
}

CorotatedTerm::CorotatedTerm(const Prisms& prisms, const std::vector<Lame>& materials, int num_vertices)
    : LaneTerm<CorotatedLanes>(
          Stencils(6, std::vector<int>(prisms.data(), prisms.data() + prisms.size()), num_vertices)),
      rotations_(num_vertices, Eigen::Matrix3d::Identity())
{
    require(stencils().size() == int(materials.size()), "{} prisms of {} materials", stencils().size(),
            materials.size());
    rests_.resize(materials.size());
    for (int p = 0; p < stencils().size(); ++p) {
        rests_[p].material = materials[p];
        for (int a = 0; a < 6; ++a) rests_[p].rotations[a] = &rotations_[stencils().corners(p)[a]];
    }
}

void CorotatedTerm::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    for (int p = 0; p < stencils().size(); ++p) {
        const PrismVertices corners = corner_positions<6>(rest_vertices, stencils().corners(p));
        rests_[p].weight = prism_volume(corners);
        require(rests_[p].weight > 0, "rest prism {} has volume {} m^3", p, rests_[p].weight);
        rests_[p].gradient = prism_gradient_operator(corners);
    }
}

void CorotatedTerm::set_rotations(const std::vector<Eigen::Matrix3d>& rotations)
{
    require(rotations.size() == rotations_.size(), "{} rotations of {} vertices", rotations.size(), rotations_.size());
    std::copy(rotations.begin(), rotations.end(), rotations_.begin());
}

}  // namespace ndg
