// SPDX-License-Identifier: Apache-2.0
// A layer of soft tissue as tetrahedra, some of whose vertices are held to the skinned shape (Romero et al. 2020).
#pragma once

#include "ndg/core/options.h"
#include "ndg/elastic/elastic_body.h"
#include "ndg/elastic/unposed_term.h"

#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// M vertices, the first of which are held.
struct SoftBody {
    std::string name;          ///< in messages
    Points rest;               ///< M x 3, unposed, m
    int num_held = 0;          ///< rows of `rest`
    Tetrahedra tetrahedra;     ///< D x 4
    Triangles skin_triangles;  ///< vertices of the volume
    Points normals;            ///< M x 3: the skin's normal carried inside; their length does not matter
    Eigen::VectorXd young_normal_pascal, young_tangent_pascal;  ///< M each

    int num_vertices() const { return static_cast<int>(rest.rows()); }
    /// Throws InputError naming body, item and value: counts that do not fit, values that are not finite, moduli that
    /// are not positive, tetrahedra without volume, free vertices that belong to none, elements whose normals cancel.
    void check() const;
};

/// fung: orthotropic and saturating (elastic/orthotropic_material.h). neo_hookean: stable Neo-Hookean flesh (Smith, de
/// Goes and Kim 2018) of the larger of the two moduli.
enum class TissueLaw { fung, neo_hookean };
template <>
inline constexpr EnumName<TissueLaw> enum_table<TissueLaw>[] = {{TissueLaw::fung, "fung"},
                                                                {TissueLaw::neo_hookean, "neo-hookean"}};
/// What strain is measured of: unposed positions (Romero et al.), or those in the world (Kim et al. 2017).
enum class DeformationSpace { unposed, world };
template <>
inline constexpr EnumName<DeformationSpace> enum_table<DeformationSpace>[] = {{DeformationSpace::unposed, "unposed"},
                                                                              {DeformationSpace::world, "world"}};

struct TissueOptions {
    TissueLaw law = TissueLaw::fung;
    DeformationSpace space = DeformationSpace::unposed;
    double poisson_ratio = 0.2;  ///< of Romero et al.
    double saturation = 4;       ///< eta, of Romero et al.
};
void describe(OptionList& list, TissueOptions& options);

/// The tissue's energy as a term for a body of `num_vertices`, of which the first M are those of `tissue`. Moduli and
/// normals of an element are the means of its vertices'. Neo-Hookean flesh takes lambda + mu for lambda, so that in
/// small strains both laws agree where the material is isotropic. Keeps no reference.
struct TissueTerm {
    std::unique_ptr<EnergyTerm> term;
    UnposedMaps* maps = nullptr;  ///< of the term; none in world space
};
TissueTerm tissue_term(const SoftBody& tissue, const TissueOptions& options, int num_vertices);

/// Of every vertex a quarter of its tetrahedra's, kg.
Eigen::VectorXd lumped_masses(const Eigen::Ref<const Points>& rest, const Eigen::Ref<const Tetrahedra>& tetrahedra,
                              double density);

}  // namespace ndg
