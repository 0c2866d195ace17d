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

/// A pair that pushes.
struct ContactForce {
    double newton = 0;                                  ///< 0 for a pair out of reach
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< from the second part's nearest point to the first's
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();  ///< corner a is pushed along `normal` by w_a times as much
};

/// What keeps surfaces from each other and from themselves (contact_barrier.h): a sum over pairs of vertex and triangle
/// and of two edges, chosen anew as they move. Infinite where a pair touches; that no pair passes through is for who
/// moves the surfaces to see to. Within one surface a pair's reach is at most half its distance at rest, so that a
/// surface at rest has no energy. A pair of one surface weighs by the area about all four vertices, one of two surfaces
/// by that about the part with less.
class ContactTerm : public EnergyTerm {
public:
    /// `skin`: triangles among all vertices.
    ContactTerm(const Eigen::Ref<const Triangles>& skin, const ContactOptions& options, int num_vertices);
    /// Several surfaces that have no vertex in common; throws Error where two have.
    ContactTerm(const std::vector<Triangles>& surfaces, const ContactOptions& options, int num_vertices);

    /// Objectives made before do not know the pairs, and must not be used any more.
    void set_pairs(const std::vector<SurfacePair>& pairs);
    /// Has no energy while silent; forces() tells what it would be.
    void set_silent(bool silent) { silent_ = silent; }
    /// Of the rest areas about the surfaces' vertices, m^2.
    double mean_area() const;
    /// Of every element in turn.
    std::vector<ContactForce> forces(const Points& positions) const;

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
    PairCorners corners_of(const Points& positions, int element) const;
    /// m^2 that a pair stands for.
    double area_of(const SurfacePair& pair) const;

    std::vector<Triangles> surfaces_;
    std::vector<int> surface_of_;  ///< of every vertex, -1: none
    ContactOptions options_;
    Points rest_;
    Eigen::VectorXd areas_;  ///< of every vertex: a third of its triangles', m^2
    std::vector<Pair> pairs_;
    bool silent_ = false;
};

}  // namespace ndg
