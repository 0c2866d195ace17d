// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/volume_guard_term.h"

#include "ndg/core/error.h"
#include "ndg/elastic/element_batches.h"
#include "ndg/elastic/elements.h"

namespace ndg {

namespace {

using Batch = ElementBatch<VolumeGuardTerm::Rest>;

/// Whether the volume (supplement equation 15) or a corner's Jacobian of any is in the guard's reach.
bool any_guarded(const Points& positions, const Batch& batch)
{
    // x = xi outer + (1 - xi) inner: d alpha x d beta is quadratic in xi, with means 1/3 and 1/6 of xi^2, xi (1 - xi).
    const std::array<Lanes3, 6> x = gather_corners<6>(positions, batch.corners);
    const Lanes3 outer0 = x[0] - x[2], outer1 = x[1] - x[2], inner0 = x[3] - x[5], inner1 = x[4] - x[5];
    const Lanes3 up = (x[0] + x[1] + x[2]) - (x[3] + x[4] + x[5]);
    const Lanes3 outer = cross(outer0, outer1), inner = cross(inner0, inner1);
    const Lanes3 area = Lanes(2.0) * (outer + inner) + cross(outer0, inner1) + cross(inner0, outer1);
    const Lanes rest_volume = gather_lanes(batch.rests, [](const auto* rest) { return rest->volume; });
    if (any_of(dot(area, up) < 36.0 * guarded_volume_share * rest_volume)) return true;
    for (std::size_t a = 0; a < 6; ++a) {
        const Lanes rest = gather_lanes(batch.rests, [a](const auto* of) { return of->corners[a]; });
        const Lanes jacobian = dot(a < 3 ? outer : inner, x[a % 3] - x[a % 3 + 3]);
        if (any_of(jacobian < guarded_corner_share * rest)) return true;
    }
    return false;
}

using Vector18 = Eigen::Matrix<double, 18, 1>;
using Matrix18 = Eigen::Matrix<double, 18, 18>;

Vector18 stacked(const PrismVertices& gradient)
{
    Vector18 result;
    for (int a = 0; a < 6; ++a) result.segment<3>(3 * a) = gradient.row(a).transpose();
    return result;
}

/// One prism's.
class GuardedPrism {
public:
    GuardedPrism(const PrismVertices& prism, const VolumeGuardTerm::Rest& rest)
        : prism_(prism), rest_(rest), guard_(volume_guard(prism_volume(prism_) / rest.volume))
    {
        for (int a = 0; a < 6; ++a) corners_[a] = corner_guard(prism_corner_jacobian(prism_, a) / rest.corners[a]);
    }
    double energy() const
    {
        double energy = guard_.energy;
        for (const VolumeGuard& corner : corners_) energy += corner.energy / 6;
        return rest_.modulus * rest_.volume * energy;
    }
    bool active() const { return energy() > 0; }
    /// Stacked.
    Vector18 forces() const
    {
        Vector18 forces = Vector18::Zero();
        for_active([&](double scale, const VolumeGuard& guard, const Vector18& gradient, const auto&) {
            forces += scale * guard.first * gradient;
        });
        return forces;
    }
    /// Semi-definite without the curvature of volume and Jacobians themselves.
    Matrix18 hessian(bool exact) const
    {
        Matrix18 hessian = Matrix18::Zero();
        for_active([&](double scale, const VolumeGuard& guard, const Vector18& gradient, const auto& curvature) {
            hessian += scale * guard.second * gradient * gradient.transpose();
            if (exact) hessian += scale * guard.first * curvature();
        });
        return hessian;
    }

private:
    /// work(joule, guard, its share's gradient, function for the share's Hessian).
    template <class Work>
    void for_active(const Work& work) const
    {
        const double scale = rest_.modulus * rest_.volume;
        if (guard_.energy > 0) {
            work(scale, guard_, stacked(prism_volume_gradient(prism_) / rest_.volume),
                 [&]() -> Matrix18 { return prism_volume_hessian(prism_) / rest_.volume; });
        }
        for (int a = 0; a < 6; ++a) {
            if (!(corners_[a].energy > 0)) continue;
            work(scale / 6, corners_[a], stacked(prism_corner_jacobian_gradient(prism_, a) / rest_.corners[a]),
                 [&]() -> Matrix18 { return prism_corner_jacobian_hessian(prism_, a) / rest_.corners[a]; });
        }
    }

    PrismVertices prism_;
    const VolumeGuardTerm::Rest& rest_;
    VolumeGuard guard_;
    std::array<VolumeGuard, 6> corners_;
};

}  // namespace

VolumeGuardTerm::VolumeGuardTerm(const Eigen::Ref<const Prisms>& prisms, const std::vector<double>& moduli,
                                 int num_vertices)
    : EnergyTerm(Stencils(6, std::vector<int>(prisms.data(), prisms.data() + prisms.size()), num_vertices))
{
    require(prisms.rows() == static_cast<Eigen::Index>(moduli.size()), "{} prisms of {} moduli", prisms.rows(),
            moduli.size());
    for (const double modulus : moduli) rests_.push_back({modulus, 0, {}});
}

void VolumeGuardTerm::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    for (int p = 0; p < stencils().size(); ++p) {
        const PrismVertices prism = corner_positions<6>(rest_vertices, stencils().corners(p));
        rests_[p].volume = prism_volume(prism);
        for (int a = 0; a < 6; ++a) {
            double& corner = rests_[p].corners[a];
            corner = prism_corner_jacobian(prism, a);
            require(corner > 0, "corner {} of rest prism {} has Jacobian {} m^3", a, p, corner);
        }
    }
}

/// work(place, lane of its batch, prism) for those that are guarded.
template <class Work>
void VolumeGuardTerm::for_guarded(const Points& positions, const ElementPlaces& places, const Work& work) const
{
    for_batches(stencils(), rests_, places, [&](const Batch& batch) {
        if (!any_guarded(positions, batch)) return;
        for (int i = 0; i < batch.count; ++i) {
            const GuardedPrism prism(corner_positions<6>(positions, batch.corners[i]), *batch.rests[i]);
            if (prism.active()) work(batch.places[i], i, prism);
        }
    });
}

void VolumeGuardTerm::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    for_guarded(positions, places,
                [&](int, int lane, const GuardedPrism& prism) { sum.parts[lane] += prism.energy(); });
}

void VolumeGuardTerm::add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const
{
    for_guarded(positions, places, [&](int place, int, const GuardedPrism& prism) {
        const Eigen::Matrix<double, 18, 1> forces = prism.forces();
        sum.add<6>(places.unknown(place), forces.data());
    });
}

void VolumeGuardTerm::add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                                  HessianSum& sum) const
{
    LaneBlocks<6> blocks;
    for_guarded(positions, places, [&](int place, int, const GuardedPrism& prism) {
        blocks.set_lane(0, prism.hessian(kind == HessianKind::exact));
        sum.add<6, num_lanes>(places, place, blocks.values.data());
    });
}

}  // namespace ndg
