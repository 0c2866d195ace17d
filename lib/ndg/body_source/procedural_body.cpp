// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/procedural_body.h"

#include "ndg/body_source/procedural_skin.h"
#include "ndg/body_source/procedural_surface.h"
#include "ndg/body_source/procedural_weights.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>

namespace ndg {

const char* const procedural_licence = "Body: procedural source of this project (Apache-2.0)";

namespace {

constexpr double mass_tolerance = 0.002;  // of the mass
constexpr int max_girth_steps = 12;
constexpr double min_girth = -2.5, max_girth = 9.0;

}  // namespace

struct ProceduralBody::State {
    BodyLayout layout;  ///< of the reference person
    SymmetricSurface surface;
    RowMatrix weights;
    std::vector<int> mirror;

    State() : layout(ProceduralParameters{}, 0.0)
    {
        const Field field = skin_field(layout);
        surface = mesh_skin(layout, field);
        weights = procedural_weights(layout, field, surface);
        mirror.resize(static_cast<std::size_t>(surface.vertices.rows()));
        const int shift = surface.num_half - surface.num_middle;
        for (int v = 0; v < static_cast<int>(mirror.size()); ++v)
            mirror[static_cast<std::size_t>(v)] = v < surface.num_middle ? v
                                                  : v < surface.num_half ? v + shift
                                                                         : v - shift;
    }

    /// Left half of the skin of a layout; `start` (empty: the carried reference) is near it.
    Points half_skin(const BodyLayout& to) const
    {
        const int n = surface.num_half;
        const Points carried = carry_points(layout, to, weights.topRows(n), surface.vertices.topRows(n));
        return settle_on_skin(surface, carried, skin_field(to));
    }
    double mass(const Points& half, const ProceduralParameters& p) const
    {
        const Points all = surface.complete(half);
        const double scale = p.stature_m / stature(all);
        return body_density * enclosed_volume(all, surface.triangles) * scale * scale * scale;
    }
};

ProceduralBody::ProceduralBody() : state_(std::make_unique<State>()) {}
ProceduralBody::~ProceduralBody() = default;
ProceduralBody::ProceduralBody(ProceduralBody&&) noexcept = default;

const Triangles& ProceduralBody::triangles() const
{
    return state_->surface.triangles;
}

const RowMatrix& ProceduralBody::weights() const
{
    return state_->weights;
}

const std::vector<int>& ProceduralBody::mirror() const
{
    return state_->mirror;
}

ParametricSurface ProceduralBody::evaluate(const ProceduralParameters& parameters) const
{
    parameters.check();
    // Secant method on the girth: mass grows with it, a little faster than linearly.
    double girth = std::clamp((parameters.bmi() - 22.0) / 6.0, -1.0, 3.5), low = min_girth, high = max_girth;
    double last_girth = girth, last_mass = 0.0;
    Points half;
    for (int step = 0;; ++step) {
        half = state_->half_skin(BodyLayout(parameters, girth));
        const double mass = state_->mass(half, parameters);
        if (std::abs(mass / parameters.mass_kg - 1.0) < mass_tolerance) break;
        require(step < max_girth_steps,
                "procedural body: a mass of {} kg at {} m cannot be reached, {:.1f} kg came out", parameters.mass_kg,
                parameters.stature_m, mass);
        (mass < parameters.mass_kg ? low : high) = girth;
        const double slope = last_mass > 0.0 && std::abs(girth - last_girth) > 1e-9
                                 ? (mass - last_mass) / (girth - last_girth)
                                 : 0.22 * parameters.mass_kg;
        last_girth = girth;
        last_mass = mass;
        girth += (parameters.mass_kg - mass) / std::max(slope, 1.0);
        if (girth <= low || girth >= high) girth = 0.5 * (low + high);
    }
    ParametricSurface result;
    result.triangles = state_->surface.triangles;
    result.vertices = state_->surface.complete(half);
    result.joint_positions = BodyLayout(parameters, girth).joints();
    // The crown and the soles are where the skin's forms blend to: the last millimetres by scaling.
    const double scale = parameters.stature_m / stature(result.vertices);
    const double floor = result.vertices.col(1).minCoeff();
    for (Points* points : {&result.vertices, &result.joint_positions}) {
        points->col(1).array() -= floor;
        *points *= scale;
    }
    return result;
}

TemplateSource ProceduralBody::source(const ProceduralParameters& parameters) const
{
    TemplateSource result;
    result.name = "procedural";
    result.licence = procedural_licence;
    result.surface = evaluate(parameters);
    result.weights = state_->weights;
    result.joint_positions = result.surface.joint_positions;
    return result;
}

}  // namespace ndg
