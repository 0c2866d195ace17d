// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/body.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/procedural/anatomy.h"
#include "ndg/procedural/skin.h"
#include "ndg/procedural/surface.h"
#include "ndg/procedural/weights.h"

#include <algorithm>
#include <cmath>

namespace ndg {

const char* const procedural_licence = "Body: procedural source of this project (Apache-2.0)";

namespace {

constexpr double mass_tolerance = 0.002;            // of the mass
constexpr int search_rounds = 1, final_rounds = 5;  // of settling on the skin
constexpr double girth_of_a_stage = 0.9;
constexpr int max_girth_steps = 12;
constexpr double min_girth = -4.0, max_girth = 9.0;

}  // namespace

/// A person found: the layout with the fat that the mass asks for, the skin's left half and the last scaling.
struct SolvedPerson {
    BodyLayout layout;
    Points half;
    double scale, floor;

    void finish(Points& points) const
    {
        points.col(1).array() -= floor;
        points *= scale;
    }
};

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
        mirror.resize(surface.vertices.rows());
        const int shift = surface.num_half - surface.num_middle;
        for (int v = 0; v < static_cast<int>(mirror.size()); ++v)
            mirror[v] = v < surface.num_middle ? v : v < surface.num_half ? v + shift : v - shift;
    }

    /// Left half of the skin of a layout.
    Points half_skin(const BodyLayout& to, int rounds) const
    {
        // Fat is put on in stages, so that the skin beside the armpits follows rather than jumps.
        const int n = surface.num_half;
        const int stages = std::max(1, static_cast<int>(std::ceil(to.girth() / girth_of_a_stage)));
        Points displacement = Points::Zero(n, 3), half;
        for (int stage = 1; stage <= stages; ++stage) {
            const BodyLayout at(to.parameters(), to.girth() * stage / stages);
            const Points carried = carry_points(layout, at, weights.topRows(n), surface.vertices.topRows(n));
            half = settle_on_skin(surface, carried + displacement, skin_field(at), stage == stages ? rounds : 1);
            displacement = half - carried;
        }
        return half;
    }
    SolvedPerson solve(const ProceduralParameters& parameters) const;
    ParametricSurface surface_of(const SolvedPerson& person) const;
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

SolvedPerson ProceduralBody::State::solve(const ProceduralParameters& parameters) const
{
    parameters.check();
    // Secant method on the girth: mass grows with it, a little faster than linearly.
    double girth = std::clamp((parameters.bmi() - 22.0) / 6.0, -1.0, 3.5), low = min_girth, high = max_girth;
    double last_girth = girth, last_mass = 0.0;
    for (int step = 0;; ++step) {
        const BodyLayout to(parameters, girth);
        Points half = half_skin(to, search_rounds);
        const double reached = mass(half, parameters);
        if (std::abs(reached / parameters.mass_kg - 1.0) < mass_tolerance) {
            half = half_skin(to, final_rounds);
            // The crown and the soles are where the skin's forms blend to: the last millimetres by scaling.
            const double floor = half.col(1).minCoeff(), height = half.col(1).maxCoeff() - floor;
            return {to, std::move(half), parameters.stature_m / height, floor};
        }
        require(step < max_girth_steps,
                "procedural body: a mass of {} kg at {} m cannot be reached, {:.1f} kg came out", parameters.mass_kg,
                parameters.stature_m, reached);
        (reached < parameters.mass_kg ? low : high) = girth;
        const double slope = last_mass > 0.0 && std::abs(girth - last_girth) > 1e-9
                                 ? (reached - last_mass) / (girth - last_girth)
                                 : 0.22 * parameters.mass_kg;
        last_girth = girth;
        last_mass = reached;
        girth += (parameters.mass_kg - reached) / std::max(slope, 1.0);
        if (girth <= low || girth >= high) girth = 0.5 * (low + high);
    }
}

ParametricSurface ProceduralBody::State::surface_of(const SolvedPerson& person) const
{
    ParametricSurface result;
    result.triangles = surface.triangles;
    result.vertices = surface.complete(person.half);
    result.joint_positions = person.layout.joints();
    person.finish(result.vertices);
    person.finish(result.joint_positions);
    return result;
}

ParametricSurface ProceduralBody::evaluate(const ProceduralParameters& parameters) const
{
    return state_->surface_of(state_->solve(parameters));
}

TemplateSource ProceduralBody::source(const ProceduralParameters& parameters) const
{
    const SolvedPerson person = state_->solve(parameters);
    TemplateSource result;
    result.kind = SourceKind::procedural;
    result.licence = procedural_licence;
    result.surface = state_->surface_of(person);
    result.weights = state_->weights;
    result.joint_positions = result.surface.joint_positions;
    result.anatomy = procedural_anatomy(person.layout);
    for (AnatomyMesh& part : result.anatomy) person.finish(part.vertices);
    return result;
}

}  // namespace ndg
