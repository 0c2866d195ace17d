// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/options.h"
#include "ndg/elastic/energy_term.h"
#include "ndg/geometry/surface_pairs.h"

#include <vector>

namespace ndg {

/// Contact of the skin with itself.
struct ContactOptions {
    bool contact = false;
    /// Skin nearer than this to other skin is repelled, m.
    double contact_distance = 2e-3;
    /// Scale of the pressure, Pa: at half the distance it is 4.3 times as much.
    double contact_stiffness_pascal = 5e3;
};
void describe(OptionList& list, ContactOptions& options);

/// What keeps skin from skin (contact_barrier.h): a sum over pairs of vertex and triangle and of two edges, chosen anew
/// as the skin moves. Infinite where a pair touches; that no pair passes through is for who moves the skin to see to.
/// A pair's reach is at most half its distance at rest, so that skin at rest has no energy.
class ContactTerm : public EnergyTerm {
public:
    /// `skin`: triangles among all vertices.
    ContactTerm(const Eigen::Ref<const Triangles>& skin, const ContactOptions& options, int num_vertices);

    /// Objectives made before do not know the pairs, and must not be used any more.
    void set_pairs(const std::vector<SurfacePair>& pairs);

    void set_rest(const Eigen::Ref<const Points>& rest_vertices) override;
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override;
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override;
    void add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                     HessianSum& sum) const override;

private:
    struct Pair {
        PairKind kind;
        double squared_reach;   ///< m^2
        double scale;           ///< joule
        double parallel_limit;  ///< m^4, of two edges
    };
    template <class Work>
    void for_near(const Points& positions, const ElementPlaces& places, const Work& work) const;

    Triangles skin_;
    ContactOptions options_;
    Points rest_;
    Eigen::VectorXd areas_;  ///< of every vertex: a third of its triangles', m^2
    std::vector<Pair> pairs_;
};

}  // namespace ndg
