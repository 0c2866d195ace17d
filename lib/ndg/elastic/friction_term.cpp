// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/friction_term.h"

#include "ndg/core/error.h"
#include "ndg/elastic/lanes.h"

namespace ndg {

SlipNorm slip_norm(double way, double stick_way)
{
    if (way >= stick_way) return {way, 1 / way, 0};
    const double share = way / stick_way;
    return {(share * share * (1 - share / 3) + 1.0 / 3) * stick_way, (2 - share) / stick_way,
            2 * (1 - share) / stick_way};
}

void FrictionTerm::set_pairs(const Stencils& pairs)
{
    set_stencils(pairs);
    pairs_.assign(static_cast<std::size_t>(pairs.size()), {});
}

void FrictionTerm::set_step(const std::vector<ContactForce>& forces, const std::vector<double>& coefficients,
                            const Points& start, double stick_way)
{
    require(forces.size() == pairs_.size() && coefficients.size() == pairs_.size(),
            "{} forces and {} coefficients of {} pairs", forces.size(), coefficients.size(), pairs_.size());
    require(stick_way > 0, "the way within which pairs stick is {} m", stick_way);
    stick_way_ = stick_way;
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
        const int* corners = stencils().corners(static_cast<int>(p));
        pairs_[p] = {coefficients[p] * forces[p].newton, forces[p].normal, Eigen::Vector3d::Zero(), forces[p].weights};
        for (int a = 0; a < 4; ++a) pairs_[p].start += forces[p].weights[a] * start.row(corners[a]).transpose();
    }
}

/// work(place, pair, u) for those that have friction.
template <class Work>
void FrictionTerm::for_rubbing(const Points& positions, const ElementPlaces& places, const Work& work) const
{
    if (silent_) return;
    for (int place = 0; place < places.size(); ++place) {
        const int element = places.element(place);
        const Pair& pair = pairs_[static_cast<std::size_t>(element)];
        if (!(pair.newton > 0)) continue;
        const int* corners = stencils().corners(element);
        Eigen::Vector3d way = -pair.start;
        for (int a = 0; a < 4; ++a) way += pair.weights[a] * positions.row(corners[a]).transpose();
        way -= way.dot(pair.normal) * pair.normal;
        work(place, pair, way);
    }
}

void FrictionTerm::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    for_rubbing(positions, places, [&](int, const Pair& pair, const Eigen::Vector3d& way) {
        sum.parts[0] += pair.newton * slip_norm(way.norm(), stick_way_).value;
    });
}

void FrictionTerm::add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const
{
    for_rubbing(positions, places, [&](int place, const Pair& pair, const Eigen::Vector3d& way) {
        const Eigen::Vector3d force = pair.newton * slip_norm(way.norm(), stick_way_).first_over_way * way;
        Eigen::Matrix<double, 12, 1> forces;
        for (int a = 0; a < 4; ++a) forces.segment<3>(3 * a) = pair.weights[a] * force;
        sum.add<4>(places.unknown(place), forces.data());
    });
}

void FrictionTerm::add_hessian(const Points& positions, const ElementPlaces& places, HessianKind, HessianSum& sum) const
{
    LaneBlocks<4> blocks;
    for_rubbing(positions, places, [&](int place, const Pair& pair, const Eigen::Vector3d& way) {
        const double length = way.norm();
        const SlipNorm norm = slip_norm(length, stick_way_);
        Eigen::Matrix3d of_way =
            norm.first_over_way * (Eigen::Matrix3d::Identity() - pair.normal * pair.normal.transpose());
        if (length > 0) {
            const Eigen::Vector3d along = way / length;
            of_way += (norm.second - norm.first_over_way) * along * along.transpose();
        }
        Eigen::Matrix<double, 12, 12> hessian;
        for (int a = 0; a < 4; ++a) {
            for (int b = 0; b < 4; ++b) {
                hessian.block<3, 3>(3 * a, 3 * b) = pair.newton * pair.weights[a] * pair.weights[b] * of_way;
            }
        }
        blocks.set_lane(0, hessian);
        sum.add<4, num_lanes>(places, place, blocks.values.data());
    });
}

}  // namespace ndg
