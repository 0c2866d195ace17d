// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/volume_guard_term.h"

#include "ndg/core/error.h"
#include "ndg/elastic/element_batches.h"
#include "ndg/elastic/elements.h"

namespace ndg {

namespace {

using Batch = ElementBatch<VolumeGuardTerm::Rest>;

/// Volumes over rest volumes, exact (supplement equation 15).
Lanes volume_shares(const Points& positions, const Batch& batch)
{
    // x = xi outer + (1 - xi) inner: d alpha x d beta is quadratic in xi, with means 1/3 and 1/6 of xi^2, xi (1 - xi).
    const std::array<Lanes3, 6> x = gather_corners<6>(positions, batch.corners);
    const Lanes3 outer0 = x[0] - x[2], outer1 = x[1] - x[2], inner0 = x[3] - x[5], inner1 = x[4] - x[5];
    const Lanes3 up = (x[0] + x[1] + x[2]) - (x[3] + x[4] + x[5]);
    const Lanes3 area =
        Lanes(2.0) * (cross(outer0, outer1) + cross(inner0, inner1)) + cross(outer0, inner1) + cross(inner0, outer1);
    const Lanes rest_volume = gather_lanes(batch.rests, [](const auto* rest) { return rest->volume; });
    return dot(area, up) / (36.0 * rest_volume);
}

/// One prism's.
class GuardedPrism {
public:
    GuardedPrism(const PrismVertices& prism, const VolumeGuardTerm::Rest& rest)
        : prism_(prism),
          scale_(rest.modulus * rest.volume),
          rest_volume_(rest.volume),
          guard_(volume_guard(prism_volume(prism_) / rest_volume_))
    {
    }
    bool active() const { return guard_.energy > 0; }
    double energy() const { return scale_ * guard_.energy; }
    /// Stacked.
    Eigen::Matrix<double, 18, 1> forces() const { return scale_ * guard_.first * share_gradient(); }
    /// Semi-definite without the curvature of the volume itself.
    Eigen::Matrix<double, 18, 18> hessian(bool exact) const
    {
        const Eigen::Matrix<double, 18, 1> gradient = share_gradient();
        Eigen::Matrix<double, 18, 18> hessian = scale_ * guard_.second * gradient * gradient.transpose();
        if (exact) hessian += scale_ * guard_.first / rest_volume_ * prism_volume_hessian(prism_);
        return hessian;
    }

private:
    Eigen::Matrix<double, 18, 1> share_gradient() const
    {
        const PrismVertices gradient = prism_volume_gradient(prism_) / rest_volume_;
        Eigen::Matrix<double, 18, 1> stacked;
        for (int a = 0; a < 6; ++a) stacked.segment<3>(3 * a) = gradient.row(a).transpose();
        return stacked;
    }

    PrismVertices prism_;
    double scale_, rest_volume_;
    VolumeGuard guard_;
};

}  // namespace

VolumeGuardTerm::VolumeGuardTerm(const Eigen::Ref<const Prisms>& prisms, const std::vector<double>& moduli,
                                 int num_vertices)
    : EnergyTerm(Stencils(6, std::vector<int>(prisms.data(), prisms.data() + prisms.size()), num_vertices))
{
    require(prisms.rows() == static_cast<Eigen::Index>(moduli.size()), "{} prisms of {} moduli", prisms.rows(),
            moduli.size());
    for (const double modulus : moduli) rests_.push_back({modulus, 0});
}

void VolumeGuardTerm::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    for (int p = 0; p < stencils().size(); ++p) {
        rests_[p].volume = prism_volume(corner_positions<6>(rest_vertices, stencils().corners(p)));
    }
}

/// work(place, lane of its batch, prism) for those that are guarded.
template <class Work>
void VolumeGuardTerm::for_guarded(const Points& positions, const ElementPlaces& places, const Work& work) const
{
    for_batches(stencils(), rests_, places, [&](const Batch& batch) {
        if (none_of(volume_shares(positions, batch) < guarded_volume_share)) return;
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
