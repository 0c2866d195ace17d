// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/articulated_fit.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

/// Least cosine between the normals of matched places.
constexpr double min_normal_cosine = 0.5;
/// A nearest point that lies this many spacings sideways lies at the rim of a hole.
constexpr double max_sideways = 2.5;
/// Distances count up to this in the score, m.
constexpr double score_limit = 0.05;
constexpr double landmark_deviation = 0.01;
/// How many independent residuals the matches of one direction are worth: neighbouring ones err together.
constexpr double effective_matches = 300.0;
/// The prior at the first iteration, times the last one's, as standard deviations.
constexpr double first_rotation_prior = 4.0, first_scale_prior = 30.0;

/// `count` of 0..total-1, evenly.
std::vector<int> every_nth(int total, int count)
{
    std::vector<int> rows;
    const double step = std::max(1.0, static_cast<double>(total) / count);
    for (double i = 0.5 * step; i < total; i += step) rows.push_back(static_cast<int>(i));
    return rows;
}

double mean_distance(const std::vector<PlaneMatch>& matches, std::size_t total)
{
    double sum = score_limit * static_cast<double>(total - matches.size());
    for (const PlaneMatch& match : matches) sum += std::min(std::abs(match.residual), score_limit);
    return sum / static_cast<double>(std::max<std::size_t>(total, 1));
}

/// Normal equations of weighted residuals along directions at vertices.
class NormalEquations {
public:
    explicit NormalEquations(Eigen::Index size)
        : matrix(Eigen::MatrixXd::Zero(size, size)), vector(Eigen::VectorXd::Zero(size))
    {
    }
    /// `jacobian`: residuals x parameters.
    void add(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals)
    {
        matrix.selfadjointView<Eigen::Lower>().rankUpdate(jacobian.transpose());
        vector += jacobian.transpose() * residuals;
    }
    Eigen::MatrixXd matrix;
    Eigen::VectorXd vector;
};

/// Rows of the vertices in sorted, unique `rows`.
Eigen::Index row_of(const std::vector<int>& rows, int vertex)
{
    return std::lower_bound(rows.begin(), rows.end(), vertex) - rows.begin();
}

void add_matches(const std::vector<PlaneMatch>& matches, std::size_t sampled, const std::vector<int>& rows,
                 const Eigen::MatrixXd& vertex_jacobian, double reach, double deviation,
                 const Eigen::VectorXd& confidence, NormalEquations& equations)
{
    const double scale = std::sqrt(effective_matches / static_cast<double>(std::max<std::size_t>(sampled, 1)));
    Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(matches.size()), vertex_jacobian.cols());
    Eigen::VectorXd residuals(jacobian.rows());
    for (Eigen::Index i = 0; i < jacobian.rows(); ++i) {
        const PlaneMatch& match = matches[i];
        // Under clothes there is room, but no skin is outside them.
        const bool doubted = confidence.size() > 0 && match.residual < 0;
        const double confident = doubted ? confidence[match.vertex] : 1.0;
        const double weight = scale * std::sqrt(confident * geman_mcclure(match.residual, reach)) / deviation;
        const Eigen::Index row = 3 * row_of(rows, match.vertex);
        jacobian.row(i) = weight * match.normal.transpose() * vertex_jacobian.middleRows(row, 3);
        residuals[i] = weight * match.residual;
    }
    equations.add(jacobian, residuals);
}

void add_landmarks(const std::vector<LandmarkTarget>& landmarks, const Points& vertices, const std::vector<int>& rows,
                   const Eigen::MatrixXd& vertex_jacobian, NormalEquations& equations)
{
    if (landmarks.empty()) return;
    Eigen::MatrixXd jacobian =
        Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(landmarks.size()), vertex_jacobian.cols());
    Eigen::VectorXd residuals(jacobian.rows());
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
        const auto row = 3 * static_cast<Eigen::Index>(i);
        Eigen::Vector3d position = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            const int vertex = landmarks[i].vertices[k];
            position += landmarks[i].barycentric[k] * vertices.row(vertex).transpose();
            jacobian.middleRows(row, 3) += landmarks[i].barycentric[k] / landmark_deviation *
                                           vertex_jacobian.middleRows(3 * row_of(rows, vertex), 3);
        }
        residuals.segment<3>(row) = (position - landmarks[i].position) / landmark_deviation;
    }
    equations.add(jacobian, residuals);
}

/// Adds the prior and solves; parameters from `active` on stay.
Eigen::VectorXd solve_step(NormalEquations equations, const Eigen::MatrixXd& prior, const Eigen::VectorXd& parameters,
                           Eigen::Index active)
{
    equations.matrix.triangularView<Eigen::StrictlyUpper>() = equations.matrix.transpose();
    const Eigen::MatrixXd information = prior.transpose() * prior;
    equations.matrix += information;
    equations.vector += information * parameters;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(parameters.size());
    Eigen::MatrixXd head = equations.matrix.topLeftCorner(active, active);
    head.diagonal() *= 1.0 + 1e-6;
    step.head(active) = -head.ldlt().solve(equations.vector.head(active));
    // A joint turns by at most a quarter of a radian at once: beyond that the linearisation means nothing.
    const double largest = step.segment(0, active).cwiseAbs().maxCoeff();
    return largest > 0.25 ? Eigen::VectorXd(step * (0.25 / largest)) : step;
}

}  // namespace

ScanTarget::ScanTarget(Points points_, Points normals_, double spacing_)
    : points(std::move(points_)), normals(std::move(normals_)), spacing(spacing_), tree(points)
{
}

std::vector<PlaneMatch> match_surface_to_scan(const Eigen::Ref<const Points>& vertices,
                                              const Eigen::Ref<const Points>& vertex_normals,
                                              const std::vector<int>& rows, const ScanTarget& scan, double max_distance)
{
    std::vector<PlaneMatch> all(rows.size());
#pragma omp parallel for schedule(dynamic, 128)
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Eigen::Vector3d position = vertices.row(rows[i]).transpose();
        const PointTree::Neighbour found = scan.tree.nearest(position);
        if (found.squared_distance > max_distance * max_distance) continue;
        const Eigen::Vector3d normal = scan.normals.row(found.idx).transpose();
        if (normal.dot(vertex_normals.row(rows[i]).transpose()) < min_normal_cosine) continue;
        const Eigen::Vector3d offset = position - scan.points.row(found.idx).transpose();
        const double residual = offset.dot(normal);
        // Of a far surface the nearest point lies sideways anyway: a noisy surface has no exact foot points.
        const double sideways = (offset - residual * normal).norm();
        if (sideways > max_sideways * scan.spacing + 0.5 * std::abs(residual)) continue;
        all[i] = {rows[i], found.idx, residual, normal};
    }
    all.erase(std::remove_if(all.begin(), all.end(), [](const PlaneMatch& m) { return m.vertex < 0; }), all.end());
    return all;
}

std::vector<PlaneMatch> match_scan_to_surface(const Eigen::Ref<const Points>& vertices,
                                              const Eigen::Ref<const Triangles>& triangles, const ScanTarget& scan,
                                              const std::vector<int>& rows, double max_distance)
{
    const TriangleTree tree(vertices, triangles);
    const Points normals = triangle_normals(vertices, triangles);
    std::vector<PlaneMatch> all(rows.size());
#pragma omp parallel for schedule(dynamic, 128)
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Eigen::Vector3d position = scan.points.row(rows[i]).transpose();
        const ClosestPoint closest = tree.closest(position);
        if (closest.distance > max_distance) continue;
        const Eigen::Vector3d normal = normals.row(closest.triangle_idx).transpose();
        if (normal.dot(scan.normals.row(rows[i]).transpose()) < min_normal_cosine) continue;
        Eigen::Index corner = 0;
        closest.barycentric.maxCoeff(&corner);
        all[i] = {triangles(closest.triangle_idx, corner), rows[i], normal.dot(closest.point - position), normal};
    }
    all.erase(std::remove_if(all.begin(), all.end(), [](const PlaneMatch& m) { return m.vertex < 0; }), all.end());
    return all;
}

void describe(OptionList& list, ArticulatedFitOptions& options)
{
    list.add("pose-iterations", options.iterations, "of pose and proportions", 1, 1000).no_flag();
    list.add("pose-samples", options.samples, "matches in each direction", 10, 1000000).no_flag();
    list.add("first-pose-reach", options.first_reach, "of the robust weights, m", 1e-4, 10).no_flag();
    list.add("last-pose-reach", options.last_reach, "of the robust weights, m", 1e-4, 10).no_flag();
    list.add("residual-deviation", options.residual_deviation, "model error, m", 1e-5, 1).no_flag();
    list.add("proportions", options.proportions, "fit proportions too").no_flag();
}

Eigen::VectorXd fit_articulated(const ArticulatedModel& model, const ScanTarget& scan, const Eigen::VectorXd& start,
                                const std::vector<LandmarkTarget>& landmarks, const ArticulatedFitOptions& options,
                                double* score, const Eigen::VectorXd& confidence)
{
    const Triangles& triangles = model.skin().triangles;
    const std::vector<int> vertex_rows = every_nth(model.num_vertices(), options.samples);
    const std::vector<int> point_rows = every_nth(static_cast<int>(scan.points.rows()), options.samples);
    Eigen::VectorXd parameters = start;
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
        const double done = static_cast<double>(iteration) / std::max(options.iterations, 1);
        const double reach = options.first_reach * std::pow(options.last_reach / options.first_reach, done);
        const double max_distance = 3.0 * reach;
        const Points posed = model.posed_vertices(parameters);
        const auto to_scan =
            match_surface_to_scan(posed, vertex_normals(posed, triangles), vertex_rows, scan, max_distance);
        const auto to_surface = match_scan_to_surface(posed, triangles, scan, point_rows, max_distance);
        std::vector<int> rows;
        for (const auto* matches : {&to_scan, &to_surface}) {
            for (const PlaneMatch& match : *matches) rows.push_back(match.vertex);
        }
        for (const LandmarkTarget& landmark : landmarks) {
            rows.insert(rows.end(), landmark.vertices.begin(), landmark.vertices.end());
        }
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        if (rows.empty()) break;

        const Eigen::MatrixXd jacobian = model.jacobian(parameters, rows);
        NormalEquations equations(model.num_parameters());
        add_matches(to_scan, vertex_rows.size(), rows, jacobian, reach, options.residual_deviation, confidence,
                    equations);
        add_matches(to_surface, point_rows.size(), rows, jacobian, reach, options.residual_deviation, confidence,
                    equations);
        add_landmarks(landmarks, posed, rows, jacobian, equations);
        Eigen::MatrixXd prior = model.prior();
        prior.topRows(model.scale_begin()) *= std::pow(first_rotation_prior, 1.0 - done);
        prior.bottomRows(prior.rows() - model.scale_begin()) *=
            std::pow(first_scale_prior, std::max(0.0, 1.0 - 2 * done));
        parameters += solve_step(std::move(equations), prior, parameters,
                                 options.proportions ? model.num_parameters() : model.scale_begin());
    }
    if (score) *score = two_way_distance(model.posed_vertices(parameters), triangles, scan, options.samples);
    return parameters;
}

double two_way_distance(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                        const ScanTarget& scan, int samples)
{
    const std::vector<int> vertex_rows = every_nth(static_cast<int>(vertices.rows()), samples);
    const std::vector<int> point_rows = every_nth(static_cast<int>(scan.points.rows()), samples);
    const auto to_scan =
        match_surface_to_scan(vertices, vertex_normals(vertices, triangles), vertex_rows, scan, score_limit);
    const auto to_surface = match_scan_to_surface(vertices, triangles, scan, point_rows, score_limit);
    return 0.5 * (mean_distance(to_scan, vertex_rows.size()) + mean_distance(to_surface, point_rows.size()));
}

Eigen::VectorXd fit_articulated_to_vertices(const ArticulatedModel& model, const Eigen::Ref<const Points>& positions,
                                            const Eigen::VectorXd& weights, const Eigen::VectorXd& start,
                                            int iterations, bool proportions)
{
    const std::vector<int> rows = every_nth(model.num_vertices(), 1500);
    Eigen::VectorXd parameters = start;
    double weight_sum = 0.0;
    for (const int row : rows) weight_sum += weights[row];
    const double scale = std::sqrt(effective_matches / std::max(weight_sum, 1e-300));
    constexpr double deviation = 0.01;
    for (int iteration = 0; iteration < iterations; ++iteration) {
        const Points posed = model.posed_vertices(parameters, rows);
        Eigen::MatrixXd jacobian = model.jacobian(parameters, rows);
        Eigen::VectorXd residuals(jacobian.rows());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            const double factor = scale * std::sqrt(weights[rows[i]]) / deviation;
            residuals.segment<3>(3 * row) = factor * (posed.row(row) - positions.row(rows[i])).transpose();
            jacobian.middleRows(3 * row, 3) *= factor;
        }
        NormalEquations equations(model.num_parameters());
        equations.add(jacobian, residuals);
        parameters += solve_step(std::move(equations), model.prior(), parameters,
                                 proportions ? model.num_parameters() : model.scale_begin());
    }
    return parameters;
}

}  // namespace ndg
