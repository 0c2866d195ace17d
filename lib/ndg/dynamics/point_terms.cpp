// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/point_terms.h"

#include "ndg/core/error.h"

#include <numeric>

namespace ndg {

namespace {

/// One element a vertex.
Stencils every_vertex(int num_vertices)
{
    std::vector<int> vertices(num_vertices);
    std::iota(vertices.begin(), vertices.end(), 0);
    return Stencils(1, std::move(vertices), num_vertices);
}

}  // namespace

InertiaTerm::InertiaTerm(int num_vertices)
    : EnergyTerm(every_vertex(num_vertices)),
      stiffness_(Eigen::VectorXd::Zero(num_vertices)),
      inertial_(Points::Zero(num_vertices, 3))
{
}

void InertiaTerm::set_step(const Eigen::VectorXd& masses, const Points& inertial, double time_step)
{
    require(masses.size() == stiffness_.size() && inertial.rows() == stiffness_.size(),
            "{} masses and {} positions for {} vertices", masses.size(), inertial.rows(), stiffness_.size());
    stiffness_ = masses / (time_step * time_step);
    inertial_ = inertial;
}

void InertiaTerm::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const int vertex = places.element(i);
        sum.parts[static_cast<std::size_t>(i % 4)] +=
            0.5 * stiffness_[vertex] * (positions.row(vertex) - inertial_.row(vertex)).squaredNorm();
    }
}

void InertiaTerm::add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const int vertex = places.element(i);
        const Eigen::RowVector3d force = stiffness_[vertex] * (positions.row(vertex) - inertial_.row(vertex));
        sum.add<1>(places.unknown(i), force.data());
    }
}

void InertiaTerm::add_hessian(const Points&, const ElementPlaces& places, HessianKind, HessianSum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const Eigen::Matrix3d block = stiffness_[places.element(i)] * Eigen::Matrix3d::Identity();
        sum.add<1>(places, i, block.data());
    }
}

LoadTerm::LoadTerm(int num_vertices)
    : EnergyTerm(every_vertex(num_vertices)),
      forces_(Points::Zero(num_vertices, 3)),
      origins_(Points::Zero(num_vertices, 3))
{
}

void LoadTerm::set_forces(const Points& forces, const Points& origins)
{
    require(forces.rows() == forces_.rows() && origins.rows() == forces_.rows(),
            "{} forces and {} origins for {} vertices", forces.rows(), origins.rows(), forces_.rows());
    forces_ = forces;
    origins_ = origins;
}

void LoadTerm::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const int vertex = places.element(i);
        sum.parts[static_cast<std::size_t>(i % 4)] -=
            forces_.row(vertex).dot(positions.row(vertex) - origins_.row(vertex));
    }
}

void LoadTerm::add_forces(const Points&, const ElementPlaces& places, ForceSum& sum) const
{
    for (int i = 0; i < places.size(); ++i) {
        const Eigen::RowVector3d gradient = -forces_.row(places.element(i));
        sum.add<1>(places.unknown(i), gradient.data());
    }
}

}  // namespace ndg
