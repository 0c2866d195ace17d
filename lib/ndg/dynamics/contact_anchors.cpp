// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/contact_anchors.h"

namespace ndg {

void ContactAnchors::set(const std::vector<int>& vertices, const Points& targets, double stiffness)
{
    stiffness_ = stiffness;
    targets_.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    for (int i = 0; i < int(vertices.size()); ++i) targets_.row(i) = targets.row(vertices[i]);
    set_stencils(Stencils(1, vertices, stencils().num_vertices()));
}

void ContactAnchors::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const int e = places.element(i);
        sum.parts[0] += 0.5 * stiffness_ * (positions.row(*stencils().corners(e)) - targets_.row(e)).squaredNorm();
    }
}

void ContactAnchors::add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const int e = places.element(i);
        const Eigen::RowVector3d force = stiffness_ * (positions.row(*stencils().corners(e)) - targets_.row(e));
        sum.add<1>(places.unknown(i), force.data());
    }
}

void ContactAnchors::add_hessian(const Points&, const ElementPlaces& places, HessianKind, HessianSum& sum) const
{
    const Eigen::Matrix3d block = stiffness_ * Eigen::Matrix3d::Identity();
    for (int i = 0; i < places.size(); ++i) sum.add<1>(places, i, block.data());
}

}  // namespace ndg
