// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/body_sampling.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <algorithm>

namespace ndg {

void BodySamplingOptions::check() const
{
    require_input(spread >= 0.0 && spread <= 0.5, "spread is {}, allowed is 0 to 0.5", spread);
}

MakeHumanParameters sample_parameters(std::uint64_t seed, int body_idx, const BodySamplingOptions& options)
{
    options.check();
    Random random(seed, "bodies", static_cast<std::uint64_t>(body_idx));
    const auto slider = [&](double middle, double spread) {
        return std::clamp(middle + spread * random.normal(), 0.08, 0.95);
    };
    MakeHumanParameters parameters;
    parameters.sex = body_idx % 2 == 0 ? 0.0 : 1.0;
    // MakeHuman's young shape stands for 25 years and less.
    const double years = random.uniform(20.0, 75.0);
    parameters.age = 0.5 + std::max(0.0, years - 25.0) / 130.0;
    // MakeHuman's height slider spans 1.2 to 2.4 m, its average weight is slim (BMI 21), and with average muscle its
    // largest weight is only BMI 23: heavy people have little muscle there.
    parameters.weight = slider(0.65, 1.3 * options.spread);
    parameters.muscle = slider(0.35, 1.3 * options.spread);
    parameters.height = slider(0.48, 0.4 * options.spread);
    parameters.proportions = slider(0.5, options.spread);
    return parameters;
}

Body skin_on_template(const Template& body_template, const ParametricSurface& surface, const std::string& name)
{
    require_input(body_template.source_vertices.rows() == body_template.rest.skin_vertices.rows(),
                  "the template was not made from a parametric source: it has no map from the source's vertices");
    require_input(body_template.source_vertices.maxCoeff() < surface.vertices.rows(),
                  "the template's source map uses vertex {}, the source has {}",
                  body_template.source_vertices.maxCoeff(), surface.vertices.rows());
    Body body;
    body.name = name;
    const double scale = stature(surface.vertices) / stature(body_template.rest.skin_vertices);
    body.joint_positions = surface.joint_positions;
    if (body_template.source_joint_offsets.rows() > 0) body.joint_positions += scale * body_template.source_joint_offsets;
    body.skin_vertices.setZero(body_template.source_vertices.rows(), 3);
    for (Eigen::Index v = 0; v < body.skin_vertices.rows(); ++v)
        for (int k = 0; k < 3; ++k)
            body.skin_vertices.row(v) +=
                body_template.source_barycentric(v, k) * surface.vertices.row(body_template.source_vertices(v, k));
    return body;
}

}  // namespace ndg
