// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/trunk.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/placement/interpolation.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// Piecewise linear, straight on beyond the ends, averaged over x +- reach so that the slope changes gradually.
double averaged(const std::vector<double>& knots, const std::vector<double>& values, double x, double reach)
{
    constexpr int samples = 9;
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
        const double at = x + reach * (2.0 * i / (samples - 1) - 1.0);
        const std::size_t last = knots.size() - 1;
        std::size_t k = 1;
        while (k < last && at > knots[k]) ++k;
        const double slope = (values[k] - values[k - 1]) / (knots[k] - knots[k - 1]);
        sum += values[k - 1] + slope * (at - knots[k - 1]);
    }
    return sum / samples;
}

/// Soft tissue over skull and below the chin, and how far the chin may lie behind the forehead, m.
constexpr double scalp = 0.006, chin_cover = 0.008, face_depth = 0.035;

}  // namespace

Eigen::Vector3d AnatomyTarget::joint(const std::string& name) const
{
    return joints.row(standard_skeleton().joint(name)).transpose();
}

Eigen::VectorXd AnatomyTarget::region_weight(const std::vector<std::string>& prefixes) const
{
    const Skeleton& skeleton = standard_skeleton();
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(weights.rows());
    for (int j = 0; j < skeleton.num_joints(); ++j)
        for (const std::string& prefix : prefixes)
            if (skeleton.joint_names[std::size_t(j)].rfind(prefix, 0) == 0) {
                sum += weights.col(j);
                break;
            }
    return sum;
}

AxialMap::AxialMap(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target)
{
    neck_begin_ = points.at("neck_1")[1] + 0.01;
    neck_end_ = points.at("head")[1];
    fit_head(parts, points, target);
    const Skeleton& skeleton = standard_skeleton();
    Points source_joints = Points::Zero(skeleton.num_joints(), 3);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const auto point = points.find(skeleton.joint_names[j]);
        if (point != points.end()) source_joints.row(j) = point->second.transpose();
    }
    TrunkTarget trunk;
    trunk.vertices = target.vertices;
    trunk.triangles = target.triangles;
    trunk.on_trunk = on_trunk(target.weights);
    trunk.joints = target.joints;
    trunk.joints.row(skeleton.joint("head")) = head(points.at("head")).transpose();
    trunk.stature = stature(target.vertices);
    trunk.bmi = body_density * enclosed_volume(target.vertices, target.triangles) / (trunk.stature * trunk.stature);
    trunk.sex = target.female ? 0.0 : 1.0;
    below_head_.emplace(trunk_bones(parts), source_joints, trunk);
}

void AxialMap::fit_head(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target)
{
    // Above the eyes there are no ears and no chin: the skull lies under a scalp of even thickness.
    const double source_eye = 0.5 * (points.at("left_orbit")[1] + points.at("right_orbit")[1]);
    const double target_eye = 0.5 * (target.joint("left_eye")[1] + target.joint("right_eye")[1]);
    constexpr double above_eyes = 0.03;
    Eigen::Vector3d source_low(0, source_eye, 1), source_high(0, 0, -1), target_low(0, target_eye, 1),
        target_high(0, 0, -1);
    const auto widen = [](const Points& vertices, double floor, Eigen::Vector3d& low, Eigen::Vector3d& high) {
        for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
            high[1] = std::max(high[1], vertices(v, 1));
            if (vertices(v, 1) < floor) continue;
            high[0] = std::max(high[0], std::abs(vertices(v, 0)));
            low[2] = std::min(low[2], vertices(v, 2));
            high[2] = std::max(high[2], vertices(v, 2));
        }
    };
    for (const AnatomyMesh& part : parts)
        if (part.layer == AnatomyLayer::bone) widen(part.vertices, source_eye + above_eyes, source_low, source_high);
    widen(target.vertices, target_eye + above_eyes, target_low, target_high);
    target_high.array() -= scalp;
    target_low[2] += scalp;
    for (int k = 0; k < 3; ++k) {
        head_scale_[k] = (target_high[k] - target_low[k]) / (source_high[k] - source_low[k]);
        head_offset_[k] = target_low[k] - head_scale_[k] * source_low[k];
    }
    // Below the eyes the face has its own height: to the chin, the lowest skin in the midline below the nose's root.
    double source_chin = source_eye, target_chin = target_eye;
    for (const AnatomyMesh& part : parts)
        if (part.name == "Mandible") source_chin = part.vertices.col(1).minCoeff();
    const Eigen::VectorXd head_weight = target.region_weight({"head", "jaw"});
    for (Eigen::Index v = 0; v < target.vertices.rows(); ++v) {
        const bool in_face = head_weight[v] > 0.5 && std::abs(target.vertices(v, 0)) < midline_half_width &&
                             target.vertices(v, 2) > target_high[2] - face_depth;
        if (in_face) target_chin = std::min(target_chin, target.vertices(v, 1));
    }
    require(source_chin < source_eye && target_chin + chin_cover < target_eye, "the head has no chin below its eyes");
    const double face_scale = (target_eye - target_chin - chin_cover) / (source_eye - source_chin);
    head_heights_ = {source_chin, source_eye, source_high[1]};
    head_values_ = {target_eye - face_scale * (source_eye - source_chin), target_eye, target_high[1]};
}

Eigen::Vector3d AxialMap::head(const Eigen::Vector3d& source) const
{
    Eigen::Vector3d moved = head_scale_.cwiseProduct(source) + head_offset_;
    moved[1] = averaged(head_heights_, head_values_, source[1], 0.015);
    return moved;
}

Eigen::Vector3d AxialMap::trunk(const Eigen::Vector3d& source) const
{
    const double share = smoothstep(neck_begin_, neck_end_, source[1]);
    return (1.0 - share) * (*below_head_)(source) + share * head(source);
}

}  // namespace ndg
