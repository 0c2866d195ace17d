// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/layered_body.h"

#include "ndg/core/error.h"
#include "ndg/elastic/flesh_term.h"
#include "ndg/elastic/neo_hookean_lanes.h"
#include "ndg/elastic/skin_term.h"
#include "ndg/elastic/varied_layered_body.h"
#include "ndg/elastic/volume_guard_term.h"

#include <algorithm>
#include <cmath>

namespace ndg {

std::vector<Lame> prism_materials(const Template& body_template, const MaterialOptions& material)
{
    const Lame muscle = lame_parameters(material.young_muscle_pascal, material.poisson_ratio);
    const Lame fat = lame_parameters(material.young_fat_pascal, material.poisson_ratio);
    std::vector<Lame> lame(body_template.num_prisms(), muscle);
    std::fill(lame.begin() + body_template.fat_begin(), lame.end(), fat);
    return lame;
}

ElasticBody layered_body(const Template& body_template, const MaterialOptions& material)
{
    return varied_layered_body(body_template, material, Eigen::VectorXd::Ones(body_template.num_prisms()));
}

ElasticBody varied_layered_body(const Template& body_template, const MaterialOptions& material,
                                const Eigen::VectorXd& stiffness_scales)
{
    check_options(material);
    const int num_wrap = body_template.num_wrap_vertices(), num_vertices = body_template.num_volume_vertices();
    const Prisms& prisms = body_template.prisms;
    std::vector<Lame> lame = prism_materials(body_template, material);
    require(stiffness_scales.size() == static_cast<Eigen::Index>(lame.size()), "{} stiffnesses for {} prisms",
            stiffness_scales.size(), lame.size());
    for (std::size_t p = 0; p < lame.size(); ++p) {
        const double scale = stiffness_scales[static_cast<Eigen::Index>(p)];
        require(std::isfinite(scale) && scale > 0, "prism {} has {} times the stiffness of its kind", p, scale);
        lame[p].mu *= scale;
        lame[p].lambda *= scale;
    }

    ElasticBody body(num_vertices, num_wrap);
    body.add(std::make_unique<FleshTerm<NeoHookeanLanes, PrismElement>>(prisms, lame, material.flesh_stiffness,
                                                                        num_vertices));
    if (material.guards_volume()) {
        std::vector<double> moduli;
        for (const Lame& parameters : lame) moduli.push_back(material.flesh_stiffness * parameters.lambda);
        body.add(std::make_unique<VolumeGuardTerm>(prisms, moduli, num_vertices));
    }
    const Triangles skin = body_template.wrap_triangles.array() + 2 * num_wrap;
    body.add(std::make_unique<SkinTerm>(skin, material.stretch_stiffness, material.bend_stiffness, num_vertices));
    body.set_rest(body_template.rest.volume_vertices);
    return body;
}

}  // namespace ndg
