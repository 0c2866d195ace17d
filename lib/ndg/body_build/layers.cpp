// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/layers.h"

#include "ndg/body_build/bone_interior.h"
#include "ndg/body_build/inner_surface.h"
#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>

namespace ndg {

namespace {

constexpr double fat_density = 900.0;                         ///< kg/m^3 (Fidanza et al. 1953)
constexpr double min_fat_share = 0.15, max_fat_share = 0.75;  ///< of the soft tissue at a vertex
constexpr double min_tissue_share = 0.12;  ///< the bone wrap leaves at least this share of the way to the skeleton
constexpr int bisection_steps = 18;

WrapSkin wrap_skin(const Template& body_template, const Points& skin_vertices, const Points& joint_positions,
                   const RowMatrix& dense_weights)
{
    WrapSkin skin;
    const int num_wrap = body_template.num_wrap_vertices();
    skin.triangles = body_template.wrap_triangles;
    skin.joint_positions = joint_positions;
    skin.weights = dense_weights;
    skin.vertices.resize(num_wrap, 3);
    for (int w = 0; w < num_wrap; ++w) skin.vertices.row(w) = skin_vertices.row(body_template.wrap_to_skin[w]);
    return skin;
}

RowMatrix dense_wrap_weights(const Template& body_template)
{
    const int num_wrap = body_template.num_wrap_vertices();
    RowMatrix dense = RowMatrix::Zero(num_wrap, body_template.skeleton.num_joints());
    for (int w = 0; w < num_wrap; ++w) {
        const int s = body_template.wrap_to_skin[w];
        for (int k = 0; k < max_influences; ++k)
            dense(w, body_template.skin_weights.joints(s, k)) += body_template.skin_weights.weights(s, k);
    }
    return dense;
}

}  // namespace

double body_fat_share(double bmi, const Person& person)
{
    return std::clamp(0.01 * (1.2 * bmi + 0.23 * person.age_years - 10.8 * person.sex - 5.4), 0.05, 0.60);
}

Body build_layers(const Template& body_template, const Body& skin, const Person& person, double min_scaled_jacobian,
                  LayerReport* report)
{
    require_input(skin.skin_vertices.rows() == body_template.rest.skin_vertices.rows(),
                  "body {}: has {} skin vertices, the template has {}", skin.name, skin.skin_vertices.rows(),
                  body_template.rest.skin_vertices.rows());
    require_input(skin.skin_vertices.allFinite() && skin.joint_positions.allFinite(),
                  "body {}: a skin vertex or joint position is not finite", skin.name);
    const int num_wrap = body_template.num_wrap_vertices();
    const RowMatrix dense_weights = dense_wrap_weights(body_template);
    const WrapSkin template_skin =
        wrap_skin(body_template, body_template.rest.skin_vertices, body_template.rest.joint_positions, dense_weights);
    const WrapSkin body_skin = wrap_skin(body_template, skin.skin_vertices, skin.joint_positions, dense_weights);

    LayerReport result;
    result.stature_m = stature(skin.skin_vertices);
    result.mass_kg = body_density * enclosed_volume(skin.skin_vertices, body_template.skin_triangles);
    result.bmi = result.mass_kg / (result.stature_m * result.stature_m);
    result.body_fat_share = body_fat_share(result.bmi, person);

    // Bone wrap: as far from the skeleton as the template's, scaled by stature.
    const Points template_projection = skeleton_projection(template_skin), projection = skeleton_projection(body_skin);
    const Points template_bone = body_template.rest.volume_vertices.topRows(num_wrap);
    const double scale = result.stature_m / stature(body_template.rest.skin_vertices);
    Points intended(num_wrap, 3);
    for (int w = 0; w < num_wrap; ++w) {
        const Eigen::RowVector3d to_skin = body_skin.vertices.row(w) - projection.row(w);
        const double template_distance = (template_skin.vertices.row(w) - template_projection.row(w)).norm();
        const double template_radius = (template_bone.row(w) - template_projection.row(w)).norm();
        const double radius =
            std::min(scale * std::min(template_radius, template_distance), (1.0 - min_tissue_share) * to_skin.norm());
        intended.row(w) = projection.row(w) + radius * to_skin.normalized();
    }

    // Muscle wrap: one share of the soft tissue, found by bisection on the volume of the fat layer.
    const Prisms fat_prisms = body_template.prisms.bottomRows(body_template.num_prisms() / 2);
    const auto place = [&](double share) {
        return valid_wraps(body_skin, intended, Eigen::VectorXd::Constant(num_wrap, share), min_scaled_jacobian,
                           skin.name);
    };
    Wraps wraps;
    Body body = skin;
    const auto fat_volume = [&](double share) {
        wraps = place(share);
        body.volume_vertices.resize(3 * num_wrap, 3);
        body.volume_vertices << wraps.bone, wraps.muscle, body_skin.vertices;
        return prism_volumes(body.volume_vertices, fat_prisms).sum();
    };
    const double wanted = result.body_fat_share * result.mass_kg / fat_density;
    double low = min_fat_share, high = max_fat_share;
    for (int step = 0; step < bisection_steps && high - low > 1e-3; ++step) {
        const double middle = 0.5 * (low + high);
        (fat_volume(middle) < wanted ? low : high) = middle;
    }
    const double volume = fat_volume(0.5 * (low + high));
    result.fat_layer_litre = 1e3 * volume;
    result.fat_layer_share = volume * fat_density / result.mass_kg;
    result.muscle_layer_litre =
        1e3 * prism_volumes(body.volume_vertices, body_template.prisms.topRows(body_template.num_prisms() / 2)).sum();
    // What counts is the body as it is stored.
    const Points stored = body.volume_vertices.cast<float>().cast<double>();
    const PrismCheck check = check_prisms(stored, body_template.prisms);
    require(check.num_invalid == 0, "body {}: {} invalid prisms in single precision, worst {} with Jacobian {:.3g} m^3",
            skin.name, check.num_invalid, check.worst_prism_idx, check.min_jacobian);
    result.min_scaled_jacobian = check.min_scaled_jacobian;
    result.adjusted_vertices = wraps.adjusted_vertices;
    body.interior_vertices =
        transfer_interior(template_bone, body_template.rest.interior_vertices, body_template.tetrahedra, wraps.bone);
    if (report) *report = result;
    return body;
}

BodySet build_layers(const Template& body_template, const BodySet& skins, const std::string& skins_path,
                     double min_scaled_jacobian)
{
    const auto column = [&](const std::string& name) {
        const auto found = std::find(skins.parameter_names.begin(), skins.parameter_names.end(), name);
        require_input(found != skins.parameter_names.end(), "{}: has no body parameter '{}'", skins_path, name);
        return found - skins.parameter_names.begin();
    };
    const Eigen::Index sex = column("sex"), age = column("age_years");
    const int count = static_cast<int>(skins.bodies.size());
    BodySet bodies;
    bodies.parameter_names = {"sex",
                              "age_years",
                              "stature_m",
                              "mass_kg",
                              "bmi",
                              "body_fat_share",
                              "fat_layer_share",
                              "fat_layer_litre",
                              "muscle_layer_litre",
                              "min_scaled_jacobian"};
    bodies.bodies.resize(count);
    bodies.parameters.resize(count, static_cast<Eigen::Index>(bodies.parameter_names.size()));
    std::vector<std::string> errors(count);
    Progress progress("build-layers", count);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < count; ++b) {
        try {
            const Person person{skins.parameters(b, sex), skins.parameters(b, age)};
            LayerReport r;
            bodies.bodies[b] = build_layers(body_template, skins.bodies[b], person, min_scaled_jacobian, &r);
            bodies.parameters.row(b) << person.sex, person.age_years, r.stature_m, r.mass_kg, r.bmi, r.body_fat_share,
                r.fat_layer_share, r.fat_layer_litre, r.muscle_layer_litre, r.min_scaled_jacobian;
        } catch (const std::exception& error) {
            errors[b] = error.what();
        }
        progress.advance();
    }
    for (const std::string& error : errors) require(error.empty(), "{}", error);
    return bodies;
}

}  // namespace ndg
