// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/layers.h"

#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/layers/bone_carrying.h"
#include "ndg/wraps/bone_interior.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double min_muscle_factor = 0.05, max_muscle_factor = 8.0;  ///< muscle thickness against the template's
/// Of muscle thickness against tissue thickness: of muscles on bones, and of the abdomen with its viscera.
constexpr double muscle_exponent = 0.5, visceral_exponent = 0.9;
/// The muscle layer of the template's trunk holds viscera where it is thicker than this, m.
constexpr double visceral_begin = 0.03, visceral_end = 0.06;
constexpr double max_fat_share = 0.85;          ///< of muscle layer and fat layer together
constexpr double min_tissue_thickness = 0.004;  ///< m, of both layers together
constexpr double min_layer_thickness = 0.0012;  ///< m
constexpr double min_layer_share = 0.08;        ///< of either layer in both
constexpr int bisection_steps = 20;

/// What is stored is single precision and must be valid there too.
constexpr double least_scaled_jacobian = 0.01;

}  // namespace

std::string layers_key(const LayerFitOptions& options, const std::string& template_sha256)
{
    return run_key("layers", layers_method_version, options_key(options), {template_sha256});
}

LayerBuilder::LayerBuilder(const Template& body_template, const LayerFitOptions& options)
    : template_(body_template), options_(options), placer_(body_template)
{
    check_options(options);
    const int num_wrap = body_template.num_wrap_vertices();
    require_input(num_wrap > 0 && body_template.rest.volume_vertices.rows() == 3 * num_wrap,
                  "the template has {} volume vertices for wraps of {}", body_template.rest.volume_vertices.rows(),
                  num_wrap);
    weights_ = RowMatrix::Zero(num_wrap, body_template.skeleton.num_joints());
    for (int w = 0; w < num_wrap; ++w) {
        const int s = body_template.wrap_to_skin[w];
        for (int k = 0; k < max_influences; ++k)
            weights_(w, body_template.skin_weights.joints(s, k)) += body_template.skin_weights.weights(s, k);
    }
    bone_ = body_template.rest.volume_vertices.topRows(num_wrap);
    muscle_ = body_template.rest.volume_vertices.middleRows(num_wrap, num_wrap);
    skin_ = body_template.rest.volume_vertices.bottomRows(num_wrap);
    muscle_prisms_ = body_template.prisms.topRows(body_template.fat_begin());
    fat_prisms_ = body_template.prisms.bottomRows(body_template.fat_begin());
    stature_ = stature(body_template.rest.skin_vertices);
    tissue_exponents_.resize(num_wrap);
    const auto trunk = on_trunk(weights_);
    for (int w = 0; w < num_wrap; ++w) {
        const double thickness = (muscle_.row(w) - bone_.row(w)).norm();
        const double share = std::clamp((thickness - visceral_begin) / (visceral_end - visceral_begin), 0.0, 1.0);
        tissue_exponents_[w] = muscle_exponent + (trunk[w] ? share : 0.0) * (visceral_exponent - muscle_exponent);
    }
}

LayerSurfaces LayerBuilder::targets(const Skin& skin, double sex, double scale, LayerReport& report) const
{
    const Eigen::Index num_wrap = bone_.rows();
    LayerSurfaces surfaces;
    surfaces.skin.resize(num_wrap, 3);
    for (Eigen::Index w = 0; w < num_wrap; ++w)
        surfaces.skin.row(w) = skin.skin_vertices.row(template_.wrap_to_skin[w]);
    surfaces.bone = carried_bone_wrap(template_, weights_, surfaces.skin, skin.joint_positions, scale,
                                      placer_.trunk_map(skin, sex));
    press_under_skin(surfaces.skin, template_.wrap_triangles, min_tissue_thickness, surfaces.bone);
    const Points offsets = surfaces.bone - surfaces.skin;
    const Eigen::VectorXd tissue = offsets.rowwise().norm();
    Eigen::VectorXd muscle(num_wrap);
    for (Eigen::Index w = 0; w < num_wrap; ++w) {
        const double usual = scale * (skin_.row(w) - bone_.row(w)).norm();
        muscle[w] = scale * (muscle_.row(w) - bone_.row(w)).norm() * std::pow(tissue[w] / usual, tissue_exponents_[w]);
    }
    const auto muscle_wrap = [&](double factor) {
        Points result(num_wrap, 3);
        for (Eigen::Index w = 0; w < num_wrap; ++w) {
            const double least = std::min(0.4, std::max(min_layer_share, min_layer_thickness / tissue[w]));
            const double share = std::clamp(1.0 - factor * muscle[w] / tissue[w], least, 1.0 - least);
            result.row(w) = surfaces.skin.row(w) + share * offsets.row(w);
        }
        return result;
    };
    Points volume(3 * num_wrap, 3);
    volume << surfaces.bone, muscle_wrap(1.0), surfaces.skin;
    report.wanted_fat_litre = std::min(report.composition.subcutaneous_litre,
                                       max_fat_share * 1e3 * prism_volumes(volume, template_.prisms).sum());
    double low = min_muscle_factor, high = max_muscle_factor;
    for (int step = 0; step < bisection_steps && high - low > 1e-3; ++step) {
        const double middle = 0.5 * (low + high);
        volume.middleRows(num_wrap, num_wrap) = muscle_wrap(middle);
        (1e3 * prism_volumes(volume, fat_prisms_).sum() > report.wanted_fat_litre ? low : high) = middle;
    }
    surfaces.muscle = muscle_wrap(0.5 * (low + high));
    return surfaces;
}

Body LayerBuilder::build(const Skin& skin, const Person& person, LayerReport* report) const
{
    require_input(skin.skin_vertices.rows() == template_.rest.skin_vertices.rows(),
                  "body {}: has {} skin vertices, the template has {}", skin.name, skin.skin_vertices.rows(),
                  template_.rest.skin_vertices.rows());
    require_input(skin.joint_positions.rows() == template_.rest.joint_positions.rows(),
                  "body {}: has {} joints, the template has {}", skin.name, skin.joint_positions.rows(),
                  template_.rest.joint_positions.rows());
    require_input(skin.skin_vertices.allFinite() && skin.joint_positions.allFinite(),
                  "body {}: a skin vertex or joint position is not finite", skin.name);
    LayerReport result;
    result.stature_m = stature(skin.skin_vertices);
    result.mass_kg = body_density * enclosed_volume(skin.skin_vertices, template_.skin_triangles);
    require_input(result.stature_m > 0.0 && result.mass_kg > 0.0, "body {}: its skin encloses {} kg at {} m", skin.name,
                  result.mass_kg, result.stature_m);
    result.bmi = result.mass_kg / (result.stature_m * result.stature_m);
    result.girths = measure_girths(template_, skin);

    Points skin_wrap(bone_.rows(), 3);
    for (Eigen::Index w = 0; w < skin_wrap.rows(); ++w)
        skin_wrap.row(w) = skin.skin_vertices.row(template_.wrap_to_skin[w]);
    const double area = triangle_areas(skin_wrap, template_.wrap_triangles).sum();
    result.composition = body_composition(result.girths, result.stature_m, result.mass_kg, area, person);

    Skin placed = skin;
    placed.joint_positions = placer_.joints(skin, person.sex);
    const LayerSurfaces wanted = targets(placed, person.sex, result.stature_m / stature_, result);
    const LayerSurfaces layers = fit_layers(template_.wrap_triangles, wanted, options_, result.fit);
    const Eigen::RowVector3d place = layers.skin.row(template_.wrap_triangles(result.fit.worst_triangle, 0));
    require(result.fit.min_scaled_jacobian > least_scaled_jacobian,
            "body {}: no valid layers found: near ({:.3f}, {:.3f}, {:.3f}) m the smallest scaled Jacobian is {:.3g}",
            skin.name, place[0], place[1], place[2], result.fit.min_scaled_jacobian);

    Body body{placed, {}, {}};
    body.volume_vertices.resize(3 * bone_.rows(), 3);
    body.volume_vertices << layers.bone, layers.muscle, layers.skin;
    for (Eigen::Index w = 0; w < bone_.rows(); ++w)
        body.skin_vertices.row(template_.wrap_to_skin[w]) = layers.skin.row(w);
    // What counts is the body as it is stored.
    const Points stored = body.volume_vertices.cast<float>().cast<double>();
    const PrismCheck check = check_prisms(stored, template_.prisms);
    require(check.num_invalid == 0, "body {}: {} invalid prisms in single precision, worst {} with Jacobian {:.3g} m^3",
            skin.name, check.num_invalid, check.worst_prism_idx, check.min_jacobian);
    result.fit.min_scaled_jacobian = check.min_scaled_jacobian;
    result.fat_layer_litre = 1e3 * prism_volumes(body.volume_vertices, fat_prisms_).sum();
    result.muscle_layer_litre = 1e3 * prism_volumes(body.volume_vertices, muscle_prisms_).sum();
    body.interior_vertices =
        transfer_interior(bone_, template_.rest.interior_vertices, template_.tetrahedra, layers.bone);
    if (report) *report = result;
    return body;
}

Body build_layers(const Template& body_template, const Skin& skin, const Person& person, double min_scaled_jacobian,
                  LayerReport* report)
{
    LayerFitOptions options;
    options.min_scaled_jacobian = min_scaled_jacobian;
    return LayerBuilder(body_template, options).build(skin, person, report);
}

}  // namespace ndg
