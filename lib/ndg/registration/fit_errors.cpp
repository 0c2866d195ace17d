// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_errors.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace ndg {
namespace {

bool is_finger(const std::string& joint)
{
    constexpr std::array<std::string_view, 5> fingers = {"_thumb_", "_index_", "_middle_", "_ring_", "_pinky_"};
    return std::any_of(fingers.begin(), fingers.end(),
                       [&](std::string_view finger) { return joint.find(finger) != std::string::npos; });
}

}  // namespace

FitErrors measure_errors(const FittedBody& fitted, const TrueBody& truth, const Eigen::Ref<const Triangles>& triangles)
{
    FitErrors errors;
    const TriangleTree tree(truth.posed_skin, triangles);
    const Eigen::VectorXd areas = vertex_areas(truth.posed_skin, triangles);
    const double area = areas.sum();
    std::vector<std::pair<double, double>> distances;  // and areas
    for (Eigen::Index v = 0; v < areas.size(); ++v) {
        const double distance = tree.closest(fitted.posed_skin.row(v).transpose()).distance;
        distances.emplace_back(distance, areas[v]);
        errors.surface_mean += areas[v] / area * distance;
        errors.correspondence_mean += areas[v] / area * (fitted.posed_skin.row(v) - truth.posed_skin.row(v)).norm();
    }
    std::sort(distances.begin(), distances.end());
    double below = 0.0;
    for (const auto& [distance, share] : distances) {
        below += share;
        errors.surface_p95 = distance;
        if (below >= 0.95 * area) break;
    }
    errors.surface_max = distances.back().first;
    int count = 0;
    const Skeleton& skeleton = standard_skeleton();
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[j];
        if (is_finger(name)) continue;
        const double distance = (fitted.posed_joints.row(j) - truth.posed_joints.row(j)).norm();
        errors.joint_mean += distance;
        ++count;
        if (distance > errors.joint_max) {
            errors.joint_max = distance;
            errors.worst_joint = name;
        }
    }
    errors.joint_mean /= count;
    return errors;
}

}  // namespace ndg
