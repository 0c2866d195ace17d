// SPDX-License-Identifier: Apache-2.0
// Coulomb's friction of pairs that push each other, as an energy of one time step (incremental potential contact, Li et
// al. 2020, section 5): with u the way by which the nearest points of a pair slide on each other since the step's
// start,
//   D = mu N f(|u|), f(y) = y for y >= e, otherwise -y^3 / (3 e^2) + y^2 / e + e / 3.
// Normal forces N, normals and nearest points are those of an earlier state (lagged). Below e, the way slid in a step
// at the least speed that counts as sliding, the force grows smoothly from zero: what sticks creeps, slower than that.
#pragma once

#include "ndg/elastic/contact_term.h"

#include <vector>

namespace ndg {

/// f and what its derivatives need: f'(y) / y and f''(y).
struct SlipNorm {
    double value = 0, first_over_way = 0, second = 0;
};
SlipNorm slip_norm(double way, double stick_way);

class FrictionTerm : public EnergyTerm {
public:
    explicit FrictionTerm(int num_vertices) : EnergyTerm(Stencils(4, {}, num_vertices)) {}

    /// The pairs of a ContactTerm, in its order. None of them has friction before set_step(). Objectives made before
    /// must not be used any more.
    void set_pairs(const Stencils& pairs);
    /// The state of every pair: `forces` of the contact term, `coefficients` mu; `start`: where the step begins, N_v x
    /// 3; `stick_way`: e, m. Objectives stay as they are.
    void set_step(const std::vector<ContactForce>& forces, const std::vector<double>& coefficients, const Points& start,
                  double stick_way);

    /// Has no energy while silent.
    void set_silent(bool silent) { silent_ = silent; }

    void set_rest(const Eigen::Ref<const Points>&) override {}
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    /// Of every kind the exact one, which is positive semi-definite.
    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override;

private:
    struct Pair {
        double newton = 0;  ///< mu N
        Eigen::Vector3d normal = Eigen::Vector3d::UnitX(), start = Eigen::Vector3d::Zero();
        Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    };
    template <class Work>
    void for_rubbing(const Points& positions, const ElementPlaces& places, const Work& work) const;

    std::vector<Pair> pairs_;
    double stick_way_ = 1;
    bool silent_ = false;
};

}  // namespace ndg
