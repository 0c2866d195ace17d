// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/options.h"
#include "ndg/geometry/point_tree.h"
#include "ndg/registration/articulated_model.h"

#include <vector>

namespace ndg {

/// The scan that a surface is fitted to: metres, y up.
struct ScanTarget {
    ScanTarget(Points points_, Points normals_, double spacing_);
    Points points;   ///< N x 3
    Points normals;  ///< N x 3, outward
    double spacing;  ///< between neighbouring points, m
    PointTree tree;
};

/// A skin vertex that should lie in the plane through `target`, or on the target itself.
struct PlaneMatch {
    int vertex = -1;
    int point = -1;         ///< of the scan
    double residual = 0.0;  ///< signed distance from the plane, m
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// Nearest scan point of each of the surface's vertices `rows`, residual along the scan's normal. Left out: farther
/// than `max_distance`, normals more than 60 degrees apart, and vertices over a hole (their nearest point lies
/// sideways).
std::vector<PlaneMatch> match_surface_to_scan(const Eigen::Ref<const Points>& vertices,
                                              const Eigen::Ref<const Points>& vertex_normals,
                                              const std::vector<int>& rows, const ScanTarget& scan,
                                              double max_distance);
/// Nearest place on the surface of each of the scan's points `rows`, residual along the triangle's normal, given to the
/// nearest corner of the triangle. Left out as above, except that there are no holes.
std::vector<PlaneMatch> match_scan_to_surface(const Eigen::Ref<const Points>& vertices,
                                              const Eigen::Ref<const Triangles>& triangles, const ScanTarget& scan,
                                              const std::vector<int>& rows, double max_distance);

/// Weight of a residual in least squares by the estimator of Geman and McClure (1987), 1 at zero.
inline double geman_mcclure(double residual, double reach)
{
    const double ratio = residual / reach;
    const double weight = 1.0 / (1.0 + ratio * ratio);
    return weight * weight;
}

/// A place on the skin (three vertices, barycentric) and where the scan has it.
struct LandmarkTarget {
    Eigen::Vector3i vertices = Eigen::Vector3i::Zero();
    Eigen::Vector3d barycentric = {1.0, 0.0, 0.0};
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

struct ArticulatedFitOptions {
    int iterations = 24;
    int samples = 1200;                 ///< matches in each direction
    double first_reach = 0.10;          ///< scale of the robust weights, m, at the first iteration...
    double last_reach = 0.012;          ///< ...and the last one, geometric in between
    double residual_deviation = 0.006;  ///< m: model error against which the prior is weighed
    bool proportions = true;            ///< false: root, overall scale and joints alone
};
void describe(OptionList& list, ArticulatedFitOptions& options);

/// Pose and proportions that bring the model to the scan, from `start`: Gauss-Newton on point-to-plane distances both
/// ways with Geman-McClure weights whose reach shrinks, plus the model's prior, which is relaxed. `score` receives the
/// mean of the distances both ways, cut off at 5 cm, of unmatched points 5 cm. `confidence`: N, how much the matches of
/// a vertex count that lies inside the scan; empty: one.
Eigen::VectorXd fit_articulated(const ArticulatedModel& model, const ScanTarget& scan, const Eigen::VectorXd& start,
                                const std::vector<LandmarkTarget>& landmarks, const ArticulatedFitOptions& options,
                                double* score = nullptr, const Eigen::VectorXd& confidence = {});
/// The mean of distances that `score` above receives, of any surface.
double two_way_distance(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                        const ScanTarget& scan, int samples);

/// The same towards known positions of all vertices (N x 3; weights N >= 0): polishes pose and, if `proportions`, these
/// once the skin is registered.
Eigen::VectorXd fit_articulated_to_vertices(const ArticulatedModel& model, const Eigen::Ref<const Points>& positions,
                                            const Eigen::VectorXd& weights, const Eigen::VectorXd& start,
                                            int iterations, bool proportions);

}  // namespace ndg
