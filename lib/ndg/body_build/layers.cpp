// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/layers.h"

#include "ndg/body_build/bone_interior.h"
#include "ndg/body_build/inner_surface.h"
#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_mesh.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double fat_density = 900.0;                               ///< kg/m^3 (Fidanza et al. 1953)
constexpr double min_muscle_factor = 0.2, max_muscle_factor = 4.0;  ///< muscle thickness against the template's
constexpr double min_tissue_thickness = 0.004;                      ///< m, of both layers together
constexpr double min_layer_thickness = 0.001;                       ///< m
constexpr double min_layer_share = 0.08;                            ///< of either layer in both
constexpr int bisection_steps = 18, placement_rounds = 2;

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

/// Similarity transform for each joint that takes the bones around it (the joint, its parent and its children) from the
/// template's places to the body's. What these few points leave open, as the turn about a straight limb, stays as it
/// is.
std::vector<Eigen::Affine3d> bone_similarities(const Template& body_template, const Points& joint_positions,
                                               double scale)
{
    constexpr double prior = 0.05;  ///< weight of not turning
    const Points& from = body_template.rest.joint_positions;
    const int num_joints = body_template.skeleton.num_joints();
    std::vector<Eigen::Affine3d> result(static_cast<std::size_t>(num_joints), Eigen::Affine3d::Identity());
    for (int j = 0; j < num_joints; ++j) {
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        double spread = 0.0, stretched = 0.0;
        for (int other = 0; other < num_joints; ++other) {
            const bool parent = body_template.skeleton.parents[static_cast<std::size_t>(j)] == other;
            if (body_template.skeleton.parents[static_cast<std::size_t>(other)] != j && !parent) continue;
            const double weight = parent ? 0.3 : 1.0;
            const Eigen::Vector3d a = (from.row(other) - from.row(j)).transpose();
            const Eigen::Vector3d b = (joint_positions.row(other) - joint_positions.row(j)).transpose();
            covariance += weight * b * a.transpose();
            spread += weight * a.squaredNorm();
            stretched += weight * b.squaredNorm();
        }
        covariance += prior * spread * Eigen::Matrix3d::Identity();
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Vector3d sign = Eigen::Vector3d::Ones();
        if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
        const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
        const double size = spread > 0.0 ? std::sqrt(stretched / spread) : scale;
        Eigen::Affine3d& transform = result[static_cast<std::size_t>(j)];
        transform.linear() = size * rotation;
        transform.translation() = joint_positions.row(j).transpose() - transform.linear() * from.row(j).transpose();
    }
    return result;
}

/// Points of the template blended by these transforms.
Points carried_by_bones(const Template& body_template, const Points& joint_positions, double scale,
                        const Points& template_points, const RowMatrix& dense_weights)
{
    const std::vector<Eigen::Affine3d> transforms = bone_similarities(body_template, joint_positions, scale);
    Points carried = Points::Zero(template_points.rows(), 3);
    for (Eigen::Index w = 0; w < carried.rows(); ++w)
        for (Eigen::Index j = 0; j < dense_weights.cols(); ++j)
            if (dense_weights(w, j) > 0.0)
                carried.row(w) +=
                    dense_weights(w, j) *
                    (transforms[static_cast<std::size_t>(j)] * template_points.row(w).transpose()).transpose();
    return carried;
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
    const WrapSkin body_skin = wrap_skin(body_template, skin.skin_vertices, skin.joint_positions, dense_weights);

    LayerReport result;
    result.stature_m = stature(skin.skin_vertices);
    result.mass_kg = body_density * enclosed_volume(skin.skin_vertices, body_template.skin_triangles);
    result.bmi = result.mass_kg / (result.stature_m * result.stature_m);
    result.body_fat_share = body_fat_share(result.bmi, person);

    // Bone wrap: the template's, carried along with the bones, which do not grow with fat.
    const double scale = result.stature_m / stature(body_template.rest.skin_vertices);
    const Points template_bone = body_template.rest.volume_vertices.topRows(num_wrap);
    const Points carried = carried_by_bones(body_template, skin.joint_positions, scale, template_bone, dense_weights);
    const Points normals = vertex_normals(body_skin.vertices, body_skin.triangles);
    Points intended = carried;
    Eigen::VectorXd muscle_thickness(num_wrap);
    for (int w = 0; w < num_wrap; ++w) {
        const double depth = (body_skin.vertices.row(w) - carried.row(w)).dot(normals.row(w));
        intended.row(w) -= std::max(0.0, min_tissue_thickness - depth) * normals.row(w);
        muscle_thickness[w] =
            scale * (body_template.rest.volume_vertices.row(num_wrap + w) - template_bone.row(w)).norm();
    }

    // Muscle wrap: the template's thickness of muscle times one factor, found by bisection on the volume of the fat.
    // Repairing prisms moves few vertices, so that it is left out of the bisection and the whole done twice.
    const Prisms fat_prisms = body_template.prisms.bottomRows(body_template.num_prisms() / 2);
    const double wanted = result.body_fat_share * result.mass_kg / fat_density;
    Wraps wraps;
    Body body = skin;
    body.volume_vertices.resize(3 * num_wrap, 3);
    for (int round = 0; round < placement_rounds; ++round) {
        const Points offsets = intended - body_skin.vertices;
        const Eigen::VectorXd tissue = offsets.rowwise().norm();
        const auto fat_share = [&](double factor) {
            Eigen::VectorXd share(num_wrap);
            for (int w = 0; w < num_wrap; ++w) {
                const double least = std::min(0.4, std::max(min_layer_share, min_layer_thickness / tissue[w]));
                share[w] = std::clamp(1.0 - factor * muscle_thickness[w] / tissue[w], least, 1.0 - least);
            }
            return share;
        };
        double low = min_muscle_factor, high = max_muscle_factor;
        for (int step = 0; step < bisection_steps && high - low > 1e-3; ++step) {
            const double middle = 0.5 * (low + high);
            body.volume_vertices << intended, body_skin.vertices + fat_share(middle).asDiagonal() * offsets,
                body_skin.vertices;
            (prism_volumes(body.volume_vertices, fat_prisms).sum() > wanted ? low : high) = middle;
        }
        wraps = valid_wraps(body_skin, intended, fat_share(0.5 * (low + high)), min_scaled_jacobian, skin.name);
        intended = wraps.bone;
    }
    body.volume_vertices << wraps.bone, wraps.muscle, body_skin.vertices;
    const double volume = prism_volumes(body.volume_vertices, fat_prisms).sum();
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
