// SPDX-License-Identifier: Apache-2.0
// Energies of single vertices: what inertia makes of a time step, and loads.
#pragma once

#include "ndg/elastic/energy_term.h"

#include <vector>

namespace ndg {

/// Of every vertex m / (2 h^2) |x - y|^2, y where it would be at the end of the step without any force: with the
/// energies of all forces it is least where implicit Euler's method puts the vertices.
class InertiaTerm : public EnergyTerm {
public:
    explicit InertiaTerm(int num_vertices);

    /// `masses`: one a vertex, kg; `inertial`: y, N_v x 3, m; `time_step`: h, s. Throws Error for other numbers of
    /// vertices.
    void set_step(const Eigen::VectorXd& masses, const Points& inertial, double time_step);

    void set_rest(const Eigen::Ref<const Points>&) override {}
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override;

private:
    Eigen::VectorXd stiffness_;  ///< m / h^2, N/m
    Points inertial_;
};

/// Forces that do not depend on where vertices are: of every vertex -f . (x - origin).
class LoadTerm : public EnergyTerm {
public:
    explicit LoadTerm(int num_vertices);

    /// `forces`: N_v x 3, N; `origins`: where each does no work, N_v x 3. Throws Error for another number of vertices.
    void set_forces(const Points& forces, const Points& origins);

    void set_rest(const Eigen::Ref<const Points>&) override {}
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    void add_hessian(const Points&, const ElementPlaces&, HessianKind, HessianSum&) const override {}

private:
    Points forces_, origins_;
};

}  // namespace ndg
