// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/trunk.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {
namespace {

/// What a horizontal plane cuts out of a surface.
struct Section {
    double half_width = 0.0;
    double back = std::numeric_limits<double>::max(), front = std::numeric_limits<double>::lowest();
    bool empty() const { return front < back; }
};

/// Widens `section` by the cut of the triangles marked in `inside` (per vertex; empty: all) at height y, as far as it
/// lies within `half_width` of the midline.
void cut(const Points& vertices, const Triangles& triangles, const std::vector<char>& inside, double y,
         double half_width, Section& section)
{
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const int a = triangles(t, k), b = triangles(t, (k + 1) % 3);
            const double ya = vertices(a, 1), yb = vertices(b, 1);
            if ((ya > y) == (yb > y)) continue;
            if (!inside.empty() && (!inside[std::size_t(a)] || !inside[std::size_t(b)])) continue;
            const Eigen::RowVector3d point =
                vertices.row(a) + (y - ya) / (yb - ya) * (vertices.row(b) - vertices.row(a));
            if (std::abs(point[0]) > half_width) continue;
            section.half_width = std::max(section.half_width, std::abs(point[0]));
            section.back = std::min(section.back, point[2]);
            section.front = std::max(section.front, point[2]);
        }
    }
}

double interpolate(const std::vector<double>& knots, const std::vector<double>& values, double x)
{
    if (x <= knots.front()) return values.front();
    if (x >= knots.back()) return values.back();
    const auto next = static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), x) - knots.begin());
    const double share = (x - knots[next - 1]) / (knots[next] - knots[next - 1]);
    return (1.0 - share) * values[next - 1] + share * values[next];
}

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

void smooth(std::vector<double>& values, int steps)
{
    for (int step = 0; step < steps; ++step) {
        const std::vector<double> old = values;
        for (std::size_t i = 1; i + 1 < values.size(); ++i) values[i] = 0.25 * (old[i - 1] + 2 * old[i] + old[i + 1]);
    }
}

double smoothstep(double begin, double end, double x)
{
    const double t = std::clamp((x - begin) / (end - begin), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

bool contains(const std::string& text, const char* word)
{
    return text.find(word) != std::string::npos;
}

/// Depth of bones and muscles below the skin, m, that the trunk is fitted to: choices in the range of half the
/// skinfolds of healthy adults (skinfolds hold two layers; Durnin and Womersley 1974).
struct FatDepth {
    double back, front, side, scalp;
};
FatDepth fat_depth(bool female)
{
    return female ? FatDepth{0.010, 0.012, 0.015, 0.006} : FatDepth{0.008, 0.010, 0.011, 0.006};
}

/// Soft tissue below the chin, and how far the chin may lie behind the forehead, m.
constexpr double chin_cover = 0.008, face_depth = 0.035;
/// Depth of the back of the source's lumbar spine, m, and the share of the rig's say in where the hips are.
constexpr double loin_depth = 0.028, rig_share = 0.4;
/// Thickness of the latissimus beside the upper thorax, m, which this source leaves out.
constexpr double latissimus = 0.012;
constexpr double section_step = 0.02;
/// Half-width of the strip around the midline in which breastbone and spinous processes are looked for.
constexpr double midline = 0.015;

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

TrunkMap::TrunkMap(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target)
{
    neck_begin_ = points.at("neck_1")[1] + 0.01;
    neck_end_ = points.at("head")[1];
    fit_head(parts, points, target);
    fit_heights(points, target);
    fit_sections(parts, points, target);
}

void TrunkMap::fit_head(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target)
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
    const double scalp = fat_depth(target.female).scalp;
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
        const bool in_face = head_weight[v] > 0.5 && std::abs(target.vertices(v, 0)) < midline &&
                             target.vertices(v, 2) > target_high[2] - face_depth;
        if (in_face) target_chin = std::min(target_chin, target.vertices(v, 1));
    }
    require(source_chin < source_eye && target_chin + chin_cover < target_eye, "the head has no chin below its eyes");
    const double face_scale = (target_eye - target_chin - chin_cover) / (source_eye - source_chin);
    head_heights_ = {source_chin, source_eye, source_high[1]};
    head_values_ = {target_eye - face_scale * (source_eye - source_chin), target_eye, target_high[1]};
}

void TrunkMap::fit_heights(const BonePoints& points, const AnatomyTarget& target)
{
    const double source_hip = points.at("pelvis")[1];
    const double source_collar = 0.5 * (points.at("left_clavicle")[1] + points.at("right_clavicle")[1]);
    const double target_hip = 0.5 * (target.joint("left_thigh")[1] + target.joint("right_thigh")[1]);
    const double target_collar = 0.5 * (target.joint("left_clavicle")[1] + target.joint("right_clavicle")[1]);
    const double neck = 0.5 * (neck_begin_ + neck_end_);
    const double atlas_height = head(points.at("head"))[1];
    // The middle of the neck between collar bones and atlas keeps its share of the way.
    const double target_neck =
        target_collar + (atlas_height - target_collar) * (neck - source_collar) / (neck_end_ - source_collar);
    height_knots_ = {source_hip, source_collar, neck, neck_end_};
    height_values_ = {target_hip, target_collar, target_neck, atlas_height};
}

double TrunkMap::height(double source_height) const
{
    return averaged(height_knots_, height_values_, source_height, 0.04);
}

void TrunkMap::fit_sections(const std::vector<AnatomyMesh>& parts, const BonePoints& points,
                            const AnatomyTarget& target)
{
    const Eigen::VectorXd trunk_weight = target.region_weight({"pelvis", "spine", "neck", "left_clav", "right_clav"});
    std::vector<char> on_trunk(trunk_weight.size());
    for (Eigen::Index v = 0; v < trunk_weight.size(); ++v) on_trunk[std::size_t(v)] = trunk_weight[v] > 0.5;
    const FatDepth fat = fat_depth(target.female);
    const double stature_scale =
        (height_values_.back() - height_values_.front()) / (height_knots_.back() - height_knots_.front());
    const double hip = points.at("left_thigh")[1], crest = hip + 0.14, armpit = points.at("spine_5")[1] + 0.01;
    const double collar = 0.5 * (points.at("left_clavicle")[1] + points.at("right_clavicle")[1]);
    const double source_hip_x = 0.5 * (points.at("left_thigh")[0] - points.at("right_thigh")[0]);
    // The rig's hips stand wider apart than hip joints do; half way between the rig and the man's own breadth.
    const double rig_hip_x = 0.5 * (target.joint("left_thigh")[0] - target.joint("right_thigh")[0]);
    const double hip_scale = 0.5 * (rig_hip_x / source_hip_x + stature_scale);

    std::vector<double> side_scale;
    // The pelvis moves as one from its crest down; above the larynx the chin comes in.
    for (double y = crest - 0.02; y <= neck_begin_ + 0.02; y += section_step) {
        Section source_middle, source_side, target_middle, target_side;
        for (const AnatomyMesh& part : parts) {
            const bool is_side = contains(part.name, "rib") || contains(part.name, "external oblique") ||
                                 contains(part.name, "serratus anterior");
            const double low = part.vertices.col(1).minCoeff(), high = part.vertices.col(1).maxCoeff();
            if (y < low || y > high) continue;
            cut(part.vertices, part.triangles, {}, y, midline, source_middle);
            if (is_side) cut(part.vertices, part.triangles, {}, y, 1.0, source_side);
        }
        cut(target.vertices, target.triangles, on_trunk, height(y), midline, target_middle);
        cut(target.vertices, target.triangles, on_trunk, height(y), 1.0, target_side);
        require(!source_middle.empty() && !target_middle.empty(),
                "nothing lies in the midline at height {:.3f} m of the skeleton or {:.3f} m of the skin", y, height(y));
        section_heights_.push_back(y);
        // Back and front each say where they go; where only one of them is the skeleton's, the depth follows from the
        // stature: in front of the neck there is no breastbone, behind the pelvis there are buttocks.
        const double depth_scale = std::clamp((target_middle.front - fat.front - target_middle.back - fat.back) /
                                                  (source_middle.front - source_middle.back),
                                              0.75 * stature_scale, 1.2 * stature_scale);
        const double neck_share = smoothstep(collar, collar + 0.04, y);
        const double scale = depth_scale + neck_share * (0.95 * stature_scale - depth_scale);
        const double by_back = target_middle.back + fat.back - scale * source_middle.back;
        const double by_front = target_middle.front - fat.front - scale * source_middle.front;
        scale_z_.push_back(scale);
        offset_z_.push_back(0.5 * (1.0 + neck_share) * by_back + 0.5 * (1.0 - neck_share) * by_front);
        const double side_cover = fat.side + latissimus * smoothstep(armpit - 0.15, armpit - 0.02, y);
        const double side = (target_side.half_width - side_cover) / std::max(source_side.half_width, 0.05);
        side_scale.push_back(std::clamp(side, 0.8 * stature_scale, 1.3 * stature_scale));
    }
    add_pelvis(points, target, stature_scale, crest);
    side_scale.insert(side_scale.begin(), section_heights_.size() - side_scale.size(), side_scale.front());
    // The offset goes with the scale; smoothing both alike keeps the depth of a point where both are constant.
    smooth(scale_z_, 6);
    smooth(offset_z_, 6);
    const double armpit_scale = interpolate(section_heights_, side_scale, armpit);
    for (std::size_t i = 0; i < section_heights_.size(); ++i) {
        const double y = section_heights_[i];
        double scale = y < armpit ? side_scale[i] : armpit_scale;
        scale = hip_scale + (scale - hip_scale) * smoothstep(hip, crest, y);
        // The neck takes the head's breadth.
        scale += (head_scale_[0] - scale) * smoothstep(points.at("left_clavicle")[1], neck_end_, y);
        scale_x_.push_back(scale);
    }
    smooth(scale_x_, 6);
}

void TrunkMap::add_pelvis(const BonePoints& points, const AnatomyTarget& target, double stature_scale, double crest)
{
    // The sacrum's back goes on from the loin; the hips then are moved part of the way to the rig's, which lie further
    // back than the hip joints do.
    const double scale = stature_scale, hip = points.at("pelvis")[1], hip_depth = points.at("pelvis")[2];
    const double loin_back = scale_z_.front() * loin_depth + offset_z_.front();
    const double offset = loin_back - scale * loin_depth;
    const double rig_depth = 0.5 * (target.joint("left_thigh")[2] + target.joint("right_thigh")[2]);
    const double shift = rig_share * (rig_depth - (scale * hip_depth + offset));
    std::vector<double> heights, offsets;
    for (double y = hip - 0.08; y < section_heights_.front() - 0.5 * section_step; y += section_step) {
        heights.push_back(y);
        offsets.push_back(offset + shift * (1.0 - smoothstep(hip, crest, y)));
    }
    section_heights_.insert(section_heights_.begin(), heights.begin(), heights.end());
    offset_z_.insert(offset_z_.begin(), offsets.begin(), offsets.end());
    scale_z_.insert(scale_z_.begin(), heights.size(), scale);
}

Eigen::Vector3d TrunkMap::below_head(const Eigen::Vector3d& source) const
{
    const double y = source[1];
    return {interpolate(section_heights_, scale_x_, y) * source[0], height(y),
            interpolate(section_heights_, scale_z_, y) * source[2] + interpolate(section_heights_, offset_z_, y)};
}

Eigen::Vector3d TrunkMap::head(const Eigen::Vector3d& source) const
{
    Eigen::Vector3d moved = head_scale_.cwiseProduct(source) + head_offset_;
    moved[1] = averaged(head_heights_, head_values_, source[1], 0.015);
    return moved;
}

Eigen::Vector3d TrunkMap::trunk(const Eigen::Vector3d& source) const
{
    const double share = smoothstep(neck_begin_, neck_end_, source[1]);
    return (1.0 - share) * below_head(source) + share * head(source);
}

}  // namespace ndg
