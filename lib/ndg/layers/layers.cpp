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

constexpr double min_muscle_factor = 0.4, max_muscle_factor = 8.0;  ///< muscle thickness against the template's
constexpr double tissue_exponent = 0.5;                             ///< of muscle thickness against tissue thickness
/// The muscle layer of the template's trunk holds viscera where it is thicker than this, m.
constexpr double visceral_begin = 0.03, visceral_end = 0.06;
constexpr int visceral_smoothing = 6;
/// Fat in front of viscera over the mean fat under the skin: of all sites the abdomen's skinfold is the largest, and
/// grows fastest (anthropometry of adults, e.g. Durnin and Womersley 1974).
constexpr double abdominal_fat = 1.6, max_abdominal_fat = 12.0;
/// What the layers hold besides fat: four fifths of the skeletal muscle (the rest is between ribs, at the spine, in
/// head, hands and feet) and the viscera below the ribs, litres at 1.70 m. Fat has at least this share of what remains.
constexpr double soft_muscle_share = 0.8, abdominal_viscera = 4.0, stature_of_viscera = 1.70, least_fat_share = 0.1;
constexpr double min_tissue_thickness = 0.004;  ///< m, of both layers together
constexpr double min_layer_thickness = 0.0012;  ///< m
constexpr double min_layer_share = 0.08;        ///< of either layer in both
constexpr int bisection_steps = 20;

/// What is stored is single precision and must be valid there too.
constexpr double least_scaled_jacobian = 0.01;

/// How far the muscle layer at each wrap vertex is viscera: in front of the spine, above the hips, where it is thick.
Eigen::VectorXd visceral_shares(const Template& body_template, const std::vector<char>& trunk,
                                const Eigen::VectorXd& thickness)
{
    const Points& joints = body_template.rest.joint_positions;
    const Eigen::RowVector3d hip = joints.row(body_template.skeleton.joint("left_thigh"));
    const auto ramp = [](double x, double begin, double end) {
        return std::clamp((x - begin) / (end - begin), 0.0, 1.0);
    };
    Eigen::VectorXd shares(thickness.size());
    for (Eigen::Index w = 0; w < shares.size(); ++w) {
        const Eigen::RowVector3d skin = body_template.rest.skin_vertices.row(body_template.wrap_to_skin[w]);
        shares[w] = trunk[w] ? ramp(thickness[w], visceral_begin, visceral_end) * ramp(skin[2] - hip[2], 0.0, 0.06) *
                                   ramp(skin[1] - hip[1], 0.0, 0.06)
                             : 0.0;
    }
    const auto neighbours = vertex_neighbours(body_template.wrap_triangles, static_cast<int>(shares.size()));
    for (int step = 0; step < visceral_smoothing; ++step) {
        const Eigen::VectorXd old = shares;
        for (Eigen::Index w = 0; w < shares.size(); ++w) {
            double sum = 0.0;
            for (const int n : neighbours[w]) sum += old[n];
            shares[w] = 0.5 * old[w] + 0.5 * sum / static_cast<double>(neighbours[w].size());
        }
    }
    return shares;
}

}  // namespace

std::string layers_key(const LayerFitOptions& options, const std::string& template_sha256)
{
    return run_key("layers", layers_method_version, options_key(options), {template_sha256});
}

LayerBuilder::LayerBuilder(const Template& body_template, const LayerFitOptions& options)
    : template_(body_template), options_(options)
{
    check_options(options);
    if (SkeletonPlacer::has_trunk_bones(body_template)) placer_.emplace(body_template);
    const int num_wrap = body_template.num_wrap_vertices();
    require_input(num_wrap > 0 && body_template.rest.volume_vertices.rows() == 3 * num_wrap,
                  "the template has {} volume vertices for wraps of {}", body_template.rest.volume_vertices.rows(),
                  num_wrap);
    weights_ = dense_weights(select_weights(body_template.skin_weights, body_template.wrap_to_skin),
                             body_template.skeleton.num_joints());
    bone_ = body_template.rest.volume_vertices.topRows(num_wrap);
    muscle_ = body_template.rest.volume_vertices.middleRows(num_wrap, num_wrap);
    skin_ = body_template.rest.volume_vertices.bottomRows(num_wrap);
    muscle_prisms_ = body_template.prisms.topRows(body_template.fat_begin());
    fat_prisms_ = body_template.prisms.bottomRows(body_template.fat_begin());
    stature_ = stature(body_template.rest.skin_vertices);
    visceral_ = visceral_shares(body_template, on_trunk(weights_), (muscle_ - bone_).rowwise().norm());
}

LayerSurfaces LayerBuilder::targets(const Skin& skin, const TrunkMap& trunk, double scale, LayerReport& report) const
{
    const Eigen::Index num_wrap = bone_.rows();
    LayerSurfaces surfaces;
    surfaces.skin.resize(num_wrap, 3);
    for (Eigen::Index w = 0; w < num_wrap; ++w)
        surfaces.skin.row(w) = skin.skin_vertices.row(template_.wrap_to_skin[w]);
    surfaces.bone =
        carried_bone_wrap(template_, weights_, surfaces.skin, skin.joint_positions, scale, report.bmi, trunk);
    press_under_skin(surfaces.skin, template_.wrap_triangles, min_tissue_thickness, surfaces.bone);
    const Points offsets = surfaces.bone - surfaces.skin;
    const Eigen::VectorXd tissue = offsets.rowwise().norm();
    Eigen::VectorXd muscle(num_wrap);
    for (Eigen::Index w = 0; w < num_wrap; ++w) {
        const double usual = scale * (skin_.row(w) - bone_.row(w)).norm();
        muscle[w] = scale * (muscle_.row(w) - bone_.row(w)).norm() * std::pow(tissue[w] / usual, tissue_exponent);
    }
    const auto muscle_wrap = [&](double factor, double abdominal_share) {
        const double fat_of_abdomen = abdominal_share * report.composition.mean_fat_thickness_m;
        Points result(num_wrap, 3);
        for (Eigen::Index w = 0; w < num_wrap; ++w) {
            const double least = std::min(0.4, std::max(min_layer_share, min_layer_thickness / tissue[w]));
            const double fat = (1.0 - visceral_[w]) * (tissue[w] - factor * muscle[w]) + visceral_[w] * fat_of_abdomen;
            const double share = std::clamp(fat / tissue[w], least, 1.0 - least);
            result.row(w) = surfaces.skin.row(w) + share * offsets.row(w);
        }
        return result;
    };
    Points volume(3 * num_wrap, 3);
    volume << surfaces.bone, muscle_wrap(1.0, abdominal_fat), surfaces.skin;
    const double lean_litre = soft_muscle_share * report.composition.muscle_litre +
                              abdominal_viscera * std::pow(report.stature_m / stature_of_viscera, 3);
    const double soft_litre = 1e3 * prism_volumes(volume, template_.prisms).sum();
    report.wanted_fat_litre = std::clamp(report.composition.subcutaneous_litre, 0.0,
                                         std::max(soft_litre - lean_litre, least_fat_share * soft_litre));
    const auto fat_litre = [&](const Points& muscle_surface) {
        volume.middleRows(num_wrap, num_wrap) = muscle_surface;
        return 1e3 * prism_volumes(volume, fat_prisms_).sum();
    };
    /// Where `surface(x)`, whose fat grows or falls with x, has the fat that is wanted.
    const auto bisected = [&](double low, double high, const auto& surface) {
        const bool grows = fat_litre(surface(high)) > fat_litre(surface(low));
        for (int step = 0; step < bisection_steps && high - low > 1e-3; ++step) {
            const double middle = 0.5 * (low + high);
            ((fat_litre(surface(middle)) > report.wanted_fat_litre) == grows ? high : low) = middle;
        }
        return surface(0.5 * (low + high));
    };
    // Muscles give way to fat so far; of the very fat the abdomen takes the rest.
    if (fat_litre(muscle_wrap(min_muscle_factor, abdominal_fat)) >= report.wanted_fat_litre)
        surfaces.muscle = bisected(min_muscle_factor, max_muscle_factor,
                                   [&](double factor) { return muscle_wrap(factor, abdominal_fat); });
    else
        surfaces.muscle = bisected(abdominal_fat, max_abdominal_fat,
                                   [&](double share) { return muscle_wrap(min_muscle_factor, share); });
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
    require_input(placer_.has_value(), "the template has no spine by name, so that layers cannot be placed by it");
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
    const TrunkMap trunk = placer_->trunk_map(skin, person.sex);
    placed.joint_positions = placer_->joints(skin, trunk);
    const LayerSurfaces wanted = targets(placed, trunk, result.stature_m / stature_, result);
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
    result.fit.min_scaled_jacobian = min_scaled_jacobian(stored, template_.prisms);
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
