// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/body_sampling.h"

#include "ndg/body_source/procedural_body.h"
#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/core/random.h"
#include "ndg/geometry/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>

namespace ndg {

namespace {
constexpr double min_age_years = 20.0, max_age_years = 75.0;
}

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
    const double years = random.uniform(min_age_years, max_age_years);
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
    body.joint_positions = surface.joint_positions + scale * body_template.source_joint_offsets;
    body.skin_vertices.setZero(body_template.source_vertices.rows(), 3);
    for (Eigen::Index v = 0; v < body.skin_vertices.rows(); ++v)
        for (int k = 0; k < 3; ++k)
            body.skin_vertices.row(v) +=
                body_template.source_barycentric(v, k) * surface.vertices.row(body_template.source_vertices(v, k));
    return body;
}

namespace {

struct SampledPerson {
    ParametricSurface surface;
    double sex = 0.5, age_years = 30.0;
};

std::function<SampledPerson(int)> person_source(const Template& body_template, const std::string& makehuman_folder,
                                                std::uint64_t seed, const BodySamplingOptions& options)
{
    if (body_template.source_name == "procedural") {
        const auto source = std::make_shared<ProceduralBody>();
        return [source, seed](int b) {
            const ProceduralParameters p = sample_procedural_parameters(seed, b);
            Random random(seed, "ages", static_cast<std::uint64_t>(b));
            return SampledPerson{source->evaluate(p), p.sex, random.uniform(min_age_years, max_age_years)};
        };
    }
    require_input(body_template.source_name == "anatomy",
                  "the template was not made from a source that bodies can be drawn from (its source is '{}')",
                  body_template.source_name);
    require_input(!makehuman_folder.empty(), "the template was made from MakeHuman's body: give --makehuman");
    const auto source = std::make_shared<MakeHuman>(makehuman_folder);
    return [source, seed, options](int b) {
        const MakeHumanParameters p = sample_parameters(seed, b, options);
        return SampledPerson{source->evaluate(p), p.sex, makehuman_age_years(p.age)};
    };
}

}  // namespace

BodySet sample_skins(const Template& body_template, const std::string& makehuman_folder, int count, std::uint64_t seed,
                     const BodySamplingOptions& options)
{
    options.check();
    const auto person = person_source(body_template, makehuman_folder, seed, options);
    BodySet skins;
    skins.parameter_names = {"sex", "age_years", "stature_m", "mass_kg", "bmi"};
    skins.parameters.resize(count, 5);
    skins.bodies.resize(static_cast<std::size_t>(count));
    std::vector<std::string> errors(static_cast<std::size_t>(count));
    Progress progress("sample-bodies", static_cast<std::size_t>(count));
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < count; ++b) {
        try {
            const SampledPerson p = person(b);
            Body body = skin_on_template(body_template, p.surface, fmt::format("body_{:04d}", b));
            const double height = stature(body.skin_vertices);
            const double mass = body_density * enclosed_volume(body.skin_vertices, body_template.skin_triangles);
            skins.parameters.row(b) << p.sex, p.age_years, height, mass, mass / (height * height);
            skins.bodies[static_cast<std::size_t>(b)] = std::move(body);
        } catch (const std::exception& error) {
            errors[static_cast<std::size_t>(b)] = error.what();
        }
        progress.advance();
    }
    for (int b = 0; b < count; ++b)
        require(errors[static_cast<std::size_t>(b)].empty(), "body {}: {}", b, errors[static_cast<std::size_t>(b)]);
    return skins;
}

}  // namespace ndg
