// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_body.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/core/log.h"
#include "ndg/core/provenance.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/registration/fit_report.h"
#include "ndg/registration/raised_arms.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace ndg {
namespace {

constexpr int polish_iterations = 6;
/// Rounds of joints from the skin at rest, which needs the joints to be brought to rest.
constexpr int joint_rounds = 3;
/// Rounds of the likeliest shape, which needs the pose to be known, which needs the shape.
constexpr int shape_rounds = 3;
/// Shapes of a shoulder smaller than this are the likeliest person's, m.
constexpr double shoulder_wavelength = 0.3;

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

/// Height of the floor in the template's place, m; none where the scan had none.
std::optional<double> floor_height(const ScanPoints& scan, const InitialAlignment& alignment)
{
    if (!scan.floor) return std::nullopt;
    const Eigen::Vector3d under_feet = scan.points.colwise().mean().transpose();
    const Eigen::Vector3d normal = scan.floor->head<3>();
    return (alignment.template_from_file *
            Eigen::Vector3d(under_feet - (normal.dot(under_feet) - (*scan.floor)[3]) * normal))[1];
}

/// 1 at vertices all of whose neighbours are 1 too.
Eigen::VectorXd eroded(const Eigen::VectorXd& values, const Eigen::Ref<const Triangles>& triangles)
{
    Eigen::VectorXd result = values;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const double least = std::min({values[triangles(t, 0)], values[triangles(t, 1)], values[triangles(t, 2)]});
        for (int k = 0; k < 3; ++k) result[triangles(t, k)] = std::min(result[triangles(t, k)], least);
    }
    return result;
}

/// Least share of a hand that a fit sees near the scan where the hand is open as the template's is.
constexpr double open_hand = 0.6;
constexpr double open_hand_distance = 0.006;
/// Weight of covered skin where pose is found: clothes lie around the limbs.
constexpr double covered_confidence = 0.05;
/// Share of the distance between first surface and posed template that counts against a placement.
constexpr double bending_share = 0.5;
constexpr int placement_samples = 3000;

}  // namespace

/// A fit on its way.
struct BodyFitter::State {
    InitialAlignment alignment;
    ScanTarget target;
    std::vector<LandmarkTarget> landmarks;
    SkinnedSurface shape;    ///< what the model poses: the template, then the likeliest person...
    bool explained = false;  ///< ...from here on
    Eigen::VectorXd parameters;
    Points registered;
    std::vector<char> covered;   ///< N, where the scan does not show skin
    Eigen::VectorXd confidence;  ///< N, 0 there and next to it
};

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
    list.add("placements", options.placements, "fitted to the end where several are likely", 1, 10).no_flag();
    describe(list, options.nonrigid);
    list.add("max-mean", options.max_mean, "gate: mean distance of scan points to the skin, noise included, m", 1e-5,
             0.1);
    list.add("min-coverage", options.min_coverage, "gate: share of the scan near the skin", 0, 1);
    list.add("min-seen", options.min_seen, "gate: share of the skin that the scan shows", 0, 1);
    list.add("min-segment-seen", options.min_segment_seen,
             "gate: share of each segment that the scan shows; of hands and feet 0.6 of it", 0, 1);
    list.add("min-segment-coverage", options.min_segment_coverage, "gate: share of the scan near each segment", 0, 1);
    list.add("max-segment-mean", options.max_segment_mean, "gate: mean distance at each segment, m", 1e-5, 0.1);
    list.add("max-taller", options.max_taller, "gate: height of the fit over the scan's, m", 0, 1).no_flag();
    list.add("max-shorter", options.max_shorter, "gate: height of the scan over the fit's, m", 0, 1).no_flag();
    list.add("min-shoulder-breadth", options.min_shoulder_breadth, "gate: of the stature", 0, 1).no_flag();
    list.add("max-shoulder-breadth", options.max_shoulder_breadth, "gate: of the stature", 0, 1).no_flag();
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
      areas_(vertex_areas(model_.skin().vertices, model_.skin().triangles)),
      stiffness_(stiffness_weights(model_.skin(), options.armpit_factor, options.armpit_radius)),
      segments_(skin_segments(model_.skin().weights)),
      regressor_(model_.skin().vertices, model_.skin().weights, model_.skin().joint_positions, examples),
      prior_(model_.skin(), examples)
{
}

NamedLandmarks BodyFitter::find_landmarks(const std::string& name, const ScanLandmarks& landmarks,
                                          double metres_per_unit) const
{
    NamedLandmarks result;
    const auto count = static_cast<Eigen::Index>(landmarks.size());
    result.in_file.resize(count, 3);
    result.on_template.resize(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto& [landmark_name, position] = landmarks[i];
        const auto& known = template_.landmarks;
        const auto found = std::find_if(known.begin(), known.end(),
                                        [&, wanted = landmark_name](const Landmark& l) { return l.name == wanted; });
        require_input(found != known.end(), "{}: the template has no landmark \"{}\"", name, landmark_name);
        LandmarkTarget target;
        target.vertices = template_.skin_triangles.row(found->skin_triangle_idx).transpose();
        target.barycentric = found->barycentric;
        Eigen::RowVector3d on_template = Eigen::RowVector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            on_template += target.barycentric[k] * template_.rest.skin_vertices.row(target.vertices[k]);
        }
        result.in_file.row(i) = metres_per_unit * position.transpose();
        result.on_template.row(i) = on_template;
        result.targets.push_back(target);
    }
    return result;
}

/// The likeliest placement and the surface fitted there.
BodyFitter::State BodyFitter::first_surface(const std::string& name, const ScanPoints& scan,
                                            NamedLandmarks landmarks) const
{
    std::vector<Placement> placements;
    if (landmarks.in_file.rows() >= 3) {
        const InitialAlignment alignment = align_by_landmarks(name, landmarks.in_file, landmarks.on_template);
        Eigen::VectorXd start = Eigen::VectorXd::Zero(model_.num_parameters());
        start[6] = std::log(alignment.template_scale);
        start.segment<3>(3) = (alignment.template_scale - 1.0) * model_.skin().joint_positions.row(0).transpose();
        placements.push_back({alignment, make_target(scan, alignment.template_from_file), start, 0.0});
    } else {
        placements = find_placements(name, scan, model_, options_.articulated, options_.placements);
    }
    ArticulatedFitOptions articulated = options_.articulated;
    if (landmarks.in_file.rows() < 3) articulated.first_reach = std::min(articulated.first_reach, 0.05);

    std::optional<State> best;
    double least = 0.0;
    for (Placement& placement : placements) {
        State state = {
            placement.alignment, std::move(placement.target), landmarks.targets, model_.skin(), false, {}, {}, {}, {}};
        for (std::size_t i = 0; i < state.landmarks.size(); ++i) {
            state.landmarks[i].position = placement.alignment.template_from_file *
                                          landmarks.in_file.row(static_cast<Eigen::Index>(i)).transpose();
        }
        state.parameters = fit_articulated(model_, state.target, placement.parameters, state.landmarks, articulated);
        const Points reference = model_.posed_vertices(state.parameters);
        state.registered =
            fit_nonrigid(reference, model_.skin().triangles, state.target, reference, stiffness_, options_.nonrigid);
        const double score =
            two_way_distance(state.registered, model_.skin().triangles, state.target, placement_samples) +
            bending_share * (state.registered - reference).rowwise().norm().mean();
        log_debug("{}: up {}, {:.1f} mm with the surface", name, to_name(placement.alignment.up), 1e3 * score);
        if (best && score >= least) continue;
        least = score;
        best.emplace(std::move(state));
    }
    best->covered.assign(model_.num_vertices(), 0);
    best->confidence = Eigen::VectorXd::Ones(model_.num_vertices());
    return std::move(*best);
}

/// The person whom the examples make likeliest takes the template's place; what is not skin is left out from here on.
void BodyFitter::take_likeliest_shape(State& state) const
{
    const Triangles& triangles = model_.skin().triangles;
    std::vector<int> rows(model_.num_vertices());
    std::iota(rows.begin(), rows.end(), 0);
    Eigen::VectorXd evidence = Eigen::VectorXd::Zero(model_.num_vertices());
    std::array<double, num_skin_segments> seen{}, area{};
    for (const PlaneMatch& match : match_surface_to_scan(state.registered, vertex_normals(state.registered, triangles),
                                                         rows, state.target, options_.covered)) {
        evidence[match.vertex] = areas_[match.vertex];
        if (std::abs(match.residual) < open_hand_distance) {
            seen[static_cast<std::size_t>(segments_[match.vertex])] += areas_[match.vertex];
        }
    }
    for (const int v : rows) area[static_cast<std::size_t>(segments_[v])] += areas_[v];

    const auto is_closed_hand = [&](int v) {
        const auto s = static_cast<std::size_t>(segments_[v]);
        return pair_of(segments_[v]) == SegmentPair::hands && seen[s] > 0 && seen[s] < open_hand * area[s];
    };
    for (const int v : rows) {
        if (is_closed_hand(v)) evidence[v] = 0.0;
    }
    HemCover hems = {{}, std::vector<char>(rows.size(), 0)};
    // Shoes that stood out beside legs that show do so no less under trousers, where legs do not tell how long they
    // are.
    bool shoes = false;
    for (int round = 0; round < shape_rounds; ++round) {
        const ArticulatedModel model(state.shape);
        state.parameters =
            fit_articulated_to_vertices(model, state.registered, evidence, state.parameters, polish_iterations, true);
        Points joints = model.rest_joints(state.parameters);
        const Pose pose = model.pose(state.parameters);
        const Points rest = to_rest(state, pose, joints);
        const Eigen::VectorXd trusted = evidence.cwiseProduct(unposed_confidence(state.shape, pose));
        if (round == 1) {
            hems = find_hems(state.shape, model.posed_vertices(state.parameters), state.target, !raised_arms(pose));
        }
        constexpr auto feet = static_cast<std::size_t>(SegmentPair::feet);
        hems.dressed[feet] |= shoes;
        ShapePrior::Explanation explanation = prior_.explain(rest, trusted, hems);
        shoes = explanation.dressed[feet];
        // Heading, place and joints stay; the new shape has other proportions, and its root elsewhere.
        state.parameters.segment<3>(3) +=
            joints.row(0).transpose() - explanation.shape.joint_positions.row(0).transpose();
        state.parameters[6] = 0.0;
        state.parameters.tail(state.parameters.size() - model.scale_begin()).setZero();
        state.shape = std::move(explanation.shape);
        state.explained = true;
        state.covered = std::move(explanation.covered);
    }
    for (const int v : rows) {
        if (is_closed_hand(v)) state.covered[v] = 1;
        state.confidence[v] = state.covered[v] ? 0.0 : 1.0;
    }
    state.confidence = eroded(eroded(state.confidence, triangles), triangles);
}

/// Pose and proportions, then the surface, of the present shape.
void BodyFitter::fit_pose_and_surface(State& state) const
{
    const ArticulatedModel model(state.shape);
    ArticulatedFitOptions again = options_.articulated;
    again.first_reach = std::min(again.first_reach, 0.03);
    again.iterations = (again.iterations + 1) / 2;
    again.proportions = again.proportions && state.confidence.minCoeff() > 0;
    state.parameters = fit_articulated(model, state.target, state.parameters, state.landmarks, again, nullptr,
                                       state.confidence.cwiseMax(covered_confidence));
    const Points reference = model.posed_vertices(state.parameters);
    state.registered = fit_nonrigid(reference, model.skin().triangles, state.target, reference, stiffness_,
                                    options_.nonrigid, state.confidence);
    state.parameters = fit_articulated_to_vertices(model, state.registered, areas_, state.parameters, polish_iterations,
                                                   again.proportions);
}

/// The registered skin brought to rest; `joints` (at rest) are estimated anew with it.
Points BodyFitter::to_rest(const State& state, const Pose& pose, Points& joints) const
{
    const ArticulatedModel model(state.shape);
    const Eigen::VectorXd confidence = unposed_confidence(state.shape, pose);
    // The likeliest person as it is, without what the posed skin made of the proportions.
    const Eigen::VectorXd parameters =
        state.explained ? Eigen::VectorXd::Zero(model.num_parameters()) : state.parameters;
    const Points reference = model.rest_vertices(parameters), reference_joints = model.rest_joints(parameters);
    Points rest;
    for (int round = 0; round < joint_rounds; ++round) {
        rest = unpose(state.registered, model_.skin().weights, forward_kinematics(standard_skeleton(), joints, pose));
        if (confidence.minCoeff() < 1.0) {
            rest = complete_surface(reference, model_.skin().triangles, rest, confidence, shoulder_wavelength);
        }
        if (round + 1 < joint_rounds) {
            joints = regressor_.joints(rest);
            keep_raised_arms(pose, reference_joints, joints);
        }
    }
    return rest;
}

FittedBody BodyFitter::fit(const std::string& name, const ScanPoints& scan, const ScanLandmarks& landmarks) const
{
    const auto start_time = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
    };
    State state = first_surface(name, scan, find_landmarks(name, landmarks, scan.metres_per_unit));
    log_debug("{}: first surface after {:.2f} s", name, seconds());
    for (int round = 1; round < options_.rounds; ++round) {
        if (!prior_.empty()) take_likeliest_shape(state);
        fit_pose_and_surface(state);
        log_debug("{}: surface after {:.2f} s", name, seconds());
    }

    const ArticulatedModel model(state.shape);
    FittedBody result;
    result.pose = model.pose(state.parameters);
    Points joints = model.rest_joints(state.parameters);
    Points rest = to_rest(state, result.pose, joints);
    const Points posed = linear_blend_skinning(rest, model_.skin().weights,
                                               forward_kinematics(standard_skeleton(), joints, result.pose));
    // Feet on the floor, pelvis where the template has it.
    Eigen::RowVector3d shift = model_.skin().joint_positions.row(0) - joints.row(0);
    shift[1] = -rest.col(1).minCoeff();
    result.pose.root_translation -= shift.transpose();
    joints.rowwise() += shift;
    rest.rowwise() += shift;

    const Axis up = state.alignment.up;
    const Eigen::Isometry3d scan_from_template =
        Eigen::Isometry3d(Eigen::AngleAxisd(rotation_to_y_up(up))) * state.alignment.template_from_file.inverse();
    FitReport& report = result.report;
    report.notes = scan.notes;
    measure_fit({posed, rest, model.rest_vertices(state.parameters), joints, state.covered}, model_.skin(),
                state.target, floor_height(scan, state.alignment), options_, report);
    move_pose(scan_from_template, joints.row(0).transpose(), result.pose);
    const auto world_from_rest = forward_kinematics(standard_skeleton(), joints, result.pose);
    result.posed_skin = linear_blend_skinning(rest, model_.skin().weights, world_from_rest);
    result.posed_joints = posed_joints(joints, world_from_rest);
    result.body.name = name;
    result.body.skin_vertices = std::move(rest);
    result.body.joint_positions = std::move(joints);

    report.name = name;
    report.unit = to_name(scan.unit);
    report.unit_guessed = scan.unit_guessed;
    report.up = to_name(up);
    report.up_guessed = scan.up_axes.size() > 1;
    report.file_points = scan.file_points;
    const Eigen::Matrix3d turn = result.pose.parent_from_joint[0];
    report.heading_degrees = std::atan2(turn(0, 2), turn(2, 2)) * 180.0 / EIGEN_PI;
    report.seconds = seconds();
    return result;
}

}  // namespace ndg
