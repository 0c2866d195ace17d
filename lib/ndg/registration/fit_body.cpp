// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_body.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/core/log.h"
#include "ndg/core/provenance.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/registration/fit_report.h"
#include "ndg/registration/initial_alignment.h"
#include "ndg/registration/rest_pose.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

namespace ndg {
namespace {

/// Placements that are tried with a posed template.
constexpr int num_candidates = 4;
constexpr int trial_iterations = 10, trial_samples = 500;
constexpr int polish_iterations = 6;
/// Rounds of joints from the skin at rest, which needs the joints to be brought to rest.
constexpr int joint_rounds = 3;

Points transformed(const Points& points, const Eigen::Isometry3d& motion)
{
    return (points * motion.linear().transpose()).rowwise() + motion.translation().transpose();
}

ScanTarget make_target(const ScanPoints& scan, const Eigen::Isometry3d& template_from_file)
{
    return {transformed(scan.points, template_from_file), scan.normals * template_from_file.linear().transpose(),
            scan.spacing};
}

Points posed_joints(const Points& joints, const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    Points result(joints.rows(), 3);
    for (Eigen::Index j = 0; j < joints.rows(); ++j) {
        result.row(j) = (world_from_rest[j] * joints.row(j).transpose()).transpose();
    }
    return result;
}

/// A rigid motion after the pose.
void move_pose(const Eigen::Isometry3d& motion, const Eigen::Vector3d& root, Pose& pose)
{
    pose.root_translation = motion * Eigen::Vector3d(root + pose.root_translation) - root;
    pose.parent_from_joint[0] = motion.linear() * pose.parent_from_joint[0];
}

struct NamedLandmarks {
    Points in_file, on_template;          ///< L x 3, metres
    std::vector<LandmarkTarget> targets;  ///< positions not yet placed
};

NamedLandmarks find_landmarks(const Template& body_template, const std::string& name, const ScanLandmarks& landmarks,
                              double metres_per_unit)
{
    NamedLandmarks result;
    const auto count = static_cast<Eigen::Index>(landmarks.size());
    result.in_file.resize(count, 3);
    result.on_template.resize(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto& [landmark_name, position] = landmarks[i];
        const auto& known = body_template.landmarks;
        const auto found = std::find_if(known.begin(), known.end(),
                                        [&, wanted = landmark_name](const Landmark& l) { return l.name == wanted; });
        require_input(found != known.end(), "{}: the template has no landmark \"{}\"", name, landmark_name);
        LandmarkTarget target;
        target.vertices = body_template.skin_triangles.row(found->skin_triangle_idx).transpose();
        target.barycentric = found->barycentric;
        Eigen::RowVector3d on_template = Eigen::RowVector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            on_template += target.barycentric[k] * body_template.rest.skin_vertices.row(target.vertices[k]);
        }
        result.in_file.row(i) = metres_per_unit * position.transpose();
        result.on_template.row(i) = on_template;
        result.targets.push_back(target);
    }
    return result;
}

}  // namespace

ScanLandmarks read_scan_landmarks(const std::string& path)
{
    ScanLandmarks landmarks;
    for (const auto& [name, value] : JsonValue(path).members()) {
        const std::vector<double> position = value.numbers(3);
        landmarks.emplace_back(name, Eigen::Vector3d(position[0], position[1], position[2]));
    }
    return landmarks;
}

void describe(OptionList& list, FitOptions& options)
{
    describe(list, options.scan);
    describe(list, options.articulated);
    list.add("armpit-factor", options.armpit_factor, "weight of the regulariser at the armpits", 1, 1e8);
    list.add("armpit-radius", options.armpit_radius, "around each armpit, m", 0.001, 0.3);
    list.add("rounds", options.rounds, "of pose and proportions, then surface", 1, 10);
    describe(list, options.nonrigid);
    list.add("max-mean", options.max_mean, "gate: mean distance of scan points to the skin, noise included, m", 1e-5,
             0.1);
    list.add("min-coverage", options.min_coverage, "gate: share of the scan near the skin", 0, 1);
    list.add("min-seen", options.min_seen, "gate: share of the skin that the scan shows", 0, 1);
    list.add("covered", options.covered, "gate: near is nearer than this, m", 1e-4, 1).no_flag();
    list.add("min-stature", options.min_stature, "gate: m", 0, 10).no_flag();
    list.add("max-stature", options.max_stature, "gate: m", 0, 10).no_flag();
    list.add("max-flipped", options.max_flipped, "gate: share of the triangles", 0, 1).no_flag();
}

std::string fit_key(const FitOptions& options, const std::vector<std::string>& input_sha256)
{
    return run_key("fit", fit_method_version, options_key(options), input_sha256);
}

BodyFitter::BodyFitter(const Template& body_template, const FitOptions& options,
                       const std::vector<JointExample>& examples)
    : template_(body_template),
      options_((check_options(options), options)),
      model_({body_template.rest.skin_vertices, body_template.skin_triangles, body_template.skin_weights,
              body_template.rest.joint_positions}),
      stiffness_(stiffness_weights(model_.skin(), options.armpit_factor, options.armpit_radius)),
      regressor_(model_.skin().vertices, model_.skin().weights, model_.skin().joint_positions, examples),
      starts_(model_.skin(), regressor_, examples)
{
}

/// The registered skin brought to rest; `joints` (at rest) are estimated anew with it.
Points BodyFitter::to_rest(const Points& registered, const Pose& pose, Points& joints) const
{
    Points rest;
    for (int round = 0; round < joint_rounds; ++round) {
        rest = unpose(registered, model_.skin().weights, forward_kinematics(standard_skeleton(), joints, pose));
        if (round + 1 < joint_rounds) joints = regressor_.joints(rest);
    }
    return rest;
}

FittedBody BodyFitter::fit(const std::string& name, const ScanPoints& scan, const ScanLandmarks& landmarks) const
{
    const auto start_time = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
    };
    const SkinnedSurface& skin = model_.skin();
    NamedLandmarks named = find_landmarks(template_, name, landmarks, scan.metres_per_unit);
    const std::vector<InitialAlignment> candidates =
        named.in_file.rows() >= 3
            ? std::vector<InitialAlignment>{align_by_landmarks(name, named.in_file, named.on_template)}
            : align_initially(scan, skin, num_candidates);
    log_debug("{}: {} placements after {:.2f} s", name, candidates.size(), seconds());

    // The placement whose posed template fits best.
    const InitialAlignment* placement = nullptr;
    std::optional<ScanTarget> target;
    Eigen::VectorXd parameters;
    double best = 0.0;
    for (const InitialAlignment& candidate : candidates) {
        ScanTarget moved = make_target(scan, candidate.template_from_file);
        Eigen::VectorXd start = Eigen::VectorXd::Zero(model_.num_parameters());
        start[6] = std::log(candidate.template_scale);
        start.segment<3>(3) = (candidate.template_scale - 1.0) * skin.joint_positions.row(0).transpose();
        double score = 0.0;
        if (candidates.size() > 1) {
            ArticulatedFitOptions trial = options_.articulated;
            trial.iterations = trial_iterations;
            trial.samples = trial_samples;
            trial.last_reach = 0.02;
            start = fit_articulated(model_, moved, start, {}, trial, &score);
        }
        const Eigen::Matrix3d turn = candidate.template_from_file.linear();
        log_debug("{}: up {}, heading {:.0f} degrees, distance {:.1f} mm rigid, {:.1f} mm posed", name,
                  to_name(candidate.up), std::atan2(turn(0, 2), turn(2, 2)) * 180.0 / EIGEN_PI, 1e3 * candidate.error,
                  1e3 * score);
        if (placement != nullptr && score >= best) continue;
        best = score;
        placement = &candidate;
        target.emplace(std::move(moved));
        parameters = start;
    }
    for (std::size_t i = 0; i < named.targets.size(); ++i) {
        named.targets[i].position =
            placement->template_from_file * named.in_file.row(static_cast<Eigen::Index>(i)).transpose();
    }
    ArticulatedFitOptions articulated = options_.articulated;
    if (candidates.size() > 1) articulated.first_reach = std::min(articulated.first_reach, 0.05);
    parameters = fit_articulated(model_, *target, parameters, named.targets, articulated);
    log_debug("{}: pose and proportions after {:.2f} s", name, seconds());

    const Eigen::VectorXd areas = vertex_areas(skin.vertices, skin.triangles);
    const ArticulatedModel* model = &model_;
    std::optional<ArticulatedModel> start_model;
    Points registered;
    for (int round = 0; round < options_.rounds; ++round) {
        const bool from_example = round == 1 && !starts_.empty();
        if (round > 0) {
            parameters = fit_articulated_to_vertices(*model, registered, areas, parameters, polish_iterations);
        }
        if (from_example) {
            Points joints = model->rest_joints(parameters);
            const Points rest = to_rest(registered, model->pose(parameters), joints);
            start_model.emplace(starts_.nearest(rest));
            model = &*start_model;
            // Heading, place and joints stay; the example has other proportions, and its root elsewhere.
            parameters.segment<3>(3) += joints.row(0).transpose() - model->skin().joint_positions.row(0).transpose();
            parameters[6] = 0.0;
            parameters.tail(parameters.size() - model->scale_begin()).setZero();
            ArticulatedFitOptions again = options_.articulated;
            again.first_reach = std::min(again.first_reach, 0.03);
            again.iterations = (again.iterations + 1) / 2;
            parameters = fit_articulated(*model, *target, parameters, named.targets, again);
        }
        const Points reference = model->posed_vertices(parameters);
        registered = fit_nonrigid(reference, skin.triangles, *target, reference, stiffness_, options_.nonrigid);
        log_debug("{}: surface after {:.2f} s", name, seconds());
    }
    parameters = fit_articulated_to_vertices(*model, registered, areas, parameters, polish_iterations);

    FittedBody result;
    result.pose = model->pose(parameters);
    Points joints = model->rest_joints(parameters);
    Points rest = to_rest(registered, result.pose, joints);
    // Feet on the floor, pelvis where the template has it.
    Eigen::RowVector3d shift = skin.joint_positions.row(0) - joints.row(0);
    shift[1] = -rest.col(1).minCoeff();
    result.pose.root_translation -= shift.transpose();
    joints.rowwise() += shift;
    rest.rowwise() += shift;

    const Eigen::Isometry3d scan_from_template =
        Eigen::Isometry3d(Eigen::AngleAxisd(rotation_to_y_up(placement->up))) * placement->template_from_file.inverse();
    measure_fit(registered, rest, model->rest_vertices(parameters), skin.triangles, *target, options_, result.report);
    move_pose(scan_from_template, joints.row(0).transpose(), result.pose);
    const auto world_from_rest = forward_kinematics(standard_skeleton(), joints, result.pose);
    result.posed_skin = linear_blend_skinning(rest, skin.weights, world_from_rest);
    result.posed_joints = posed_joints(joints, world_from_rest);
    result.body.name = name;
    result.body.skin_vertices = std::move(rest);
    result.body.joint_positions = std::move(joints);

    FitReport& report = result.report;
    report.name = name;
    report.unit = to_name(scan.unit);
    report.unit_guessed = scan.unit_guessed;
    report.up = to_name(placement->up);
    report.up_guessed = scan.up_axes.size() > 1;
    report.file_points = scan.file_points;
    const Eigen::Matrix3d turn = result.pose.parent_from_joint[0];
    report.heading_degrees = std::atan2(turn(0, 2), turn(2, 2)) * 180.0 / EIGEN_PI;
    report.seconds = seconds();
    return result;
}

}  // namespace ndg
