// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/soft_body.h"

#include "ndg/core/error.h"
#include "ndg/elastic/fung_lanes.h"
#include "ndg/elastic/materials.h"
#include "ndg/elastic/neo_hookean_lanes.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double least_normal = 1e-3;

/// Mean over an element's vertices of the values, one a row.
template <class Values>
Eigen::Vector3d mean_row(const Values& values, const Eigen::Ref<const Tetrahedra>& tetrahedra, Eigen::Index element)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int a = 0; a < 4; ++a) sum += values.row(tetrahedra(element, a)).transpose();
    return sum / 4;
}

double mean_value(const Eigen::VectorXd& values, const Eigen::Ref<const Tetrahedra>& tetrahedra, Eigen::Index element)
{
    double sum = 0;
    for (int a = 0; a < 4; ++a) sum += values[tetrahedra(element, a)];
    return sum / 4;
}

template <class Law>
TissueTerm make_term(const SoftBody& tissue, const std::vector<typename Law::Material>& materials,
                     DeformationSpace space, int num_vertices)
{
    TissueTerm result;
    if (space == DeformationSpace::world) {
        result.term =
            std::make_unique<FleshTerm<Law, TetrahedronElement>>(tissue.tetrahedra, materials, 1.0, num_vertices);
        return result;
    }
    auto term =
        std::make_unique<UnposedFleshTerm<Law, TetrahedronElement>>(tissue.tetrahedra, materials, 1.0, num_vertices);
    result.maps = term.get();
    result.term = std::move(term);
    return result;
}

}  // namespace

void describe(OptionList& list, TissueOptions& options)
{
    list.add("tissue-law", options.law, "material of the soft tissue");
    list.add("deformation-space", options.space, "strain by unposed positions, or by those in the world");
    list.add("tissue-poisson-ratio", options.poisson_ratio, "Poisson's ratio of the soft tissue", 0, 0.49);
    list.add("saturation", options.saturation, "exponent eta with which the soft tissue stiffens", 1e-3, 100);
}

void SoftBody::check() const
{
    const Eigen::Index count = rest.rows();
    const auto require_count = [&](const char* what, Eigen::Index found) {
        require_input(found == count, "{}: {} of {} for {} vertices", name, found, what, count);
    };
    require_count("normals", normals.rows());
    require_count("moduli along the normal", young_normal_pascal.size());
    require_count("moduli along the skin", young_tangent_pascal.size());
    require_input(count > 0 && tetrahedra.rows() > 0, "{}: {} vertices and {} tetrahedra", name, count,
                  tetrahedra.rows());
    require_input(num_held >= 0 && num_held < count, "{}: {} held of {} vertices", name, num_held, count);
    for (Eigen::Index v = 0; v < count; ++v) {
        require_input(rest.row(v).allFinite() && normals.row(v).allFinite(),
                      "{}: position or normal of vertex {} is not finite", name, v);
        for (const double young : {young_normal_pascal[v], young_tangent_pascal[v]}) {
            require_input(std::isfinite(young) && young > 0, "{}: vertex {} has a Young's modulus of {} Pa", name, v,
                          young);
        }
    }
    std::vector<bool> used(static_cast<std::size_t>(count), false);
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        for (int a = 0; a < 4; ++a) {
            const int v = tetrahedra(t, a);
            require_input(v >= 0 && v < count, "{}: tetrahedron {} has vertex {} of {}", name, t, v, count);
            used[static_cast<std::size_t>(v)] = true;
        }
        const double volume = tetrahedron_volume(rest.row(tetrahedra(t, 0)), rest.row(tetrahedra(t, 1)),
                                                 rest.row(tetrahedra(t, 2)), rest.row(tetrahedra(t, 3)));
        require_input(volume > 0, "{}: tetrahedron {} has a volume of {:.3g} m^3", name, t, volume);
        require_input(mean_row(normals, tetrahedra, t).norm() > least_normal,
                      "{}: the normals of tetrahedron {} cancel", name, t);
    }
    for (Eigen::Index v = num_held; v < count; ++v) {
        require_input(used[static_cast<std::size_t>(v)], "{}: free vertex {} belongs to no tetrahedron", name, v);
    }
    require_input(skin_triangles.size() == 0 || (skin_triangles.minCoeff() >= 0 && skin_triangles.maxCoeff() < count),
                  "{}: the skin has vertices that are not among the {}", name, count);
}

TissueTerm tissue_term(const SoftBody& tissue, const TissueOptions& options, int num_vertices)
{
    check_options(options);
    require(num_vertices >= tissue.num_vertices(), "{} vertices for a soft body of {}", num_vertices,
            tissue.num_vertices());
    const Tetrahedra& tetrahedra = tissue.tetrahedra;
    if (options.law == TissueLaw::neo_hookean) {
        std::vector<Lame> materials;
        for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
            Lame lame = lame_parameters(std::max(mean_value(tissue.young_normal_pascal, tetrahedra, t),
                                                 mean_value(tissue.young_tangent_pascal, tetrahedra, t)),
                                        options.poisson_ratio);
            lame.lambda += lame.mu;
            materials.push_back(lame);
        }
        return make_term<NeoHookeanLanes>(tissue, materials, options.space, num_vertices);
    }
    std::vector<OrthotropicMaterial> materials;
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        materials.push_back(orthotropic_material(
            {mean_value(tissue.young_normal_pascal, tetrahedra, t),
             mean_value(tissue.young_tangent_pascal, tetrahedra, t), options.poisson_ratio, options.saturation},
            mean_row(tissue.normals, tetrahedra, t)));
    }
    return make_term<FungLanes>(tissue, materials, options.space, num_vertices);
}

Eigen::VectorXd lumped_masses(const Eigen::Ref<const Points>& rest, const Eigen::Ref<const Tetrahedra>& tetrahedra,
                              double density)
{
    const Eigen::VectorXd volumes = tetrahedron_volumes(rest, tetrahedra);
    Eigen::VectorXd masses = Eigen::VectorXd::Zero(rest.rows());
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        for (int a = 0; a < 4; ++a) masses[tetrahedra(t, a)] += density * volumes[t] / 4;
    }
    return masses;
}

}  // namespace ndg
