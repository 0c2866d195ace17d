// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/limbs.h"

#include "ndg/anatomical/fit.h"
#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

using Eigen::Vector3d;

/// Soft tissue in front of the last bone of a toe, m.
constexpr double toe_pulp = 0.004;

Eigen::Matrix3d rotation_part(const Eigen::Matrix3d& linear)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return svd.matrixU() * svd.matrixV().transpose();
}

class LimbFit {
public:
    LimbFit(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AxialMap& trunk,
            const AnatomyTarget& target, BodySide side)
        : parts_(parts),
          points_(points),
          trunk_(trunk),
          target_(target),
          body_side_(side),
          side_(to_name(side)),
          lateral_(side == BodySide::left ? 1.0 : -1.0)
    {
        const double source_height = points.at("head")[1] - points.at("left_heel")[1];
        stature_scale_ = trunk.head(points.at("head"))[1] / source_height;
    }

    std::map<std::string, Eigen::Affine3d> fit()
    {
        fit_leg();
        fit_arm();
        return std::move(transforms_);
    }

private:
    Vector3d source(const std::string& name) const { return points_.at(side_ + "_" + name); }
    Vector3d joint(const std::string& name) const { return target_.joint(side_ + "_" + name); }
    void set(const std::string& name, const Eigen::Affine3d& transform) { transforms_[side_ + "_" + name] = transform; }
    const Eigen::Affine3d& get(const std::string& name) const { return transforms_.at(side_ + "_" + name); }
    double transverse_scale(double source_length, double target_length) const
    {
        return std::sqrt(stature_scale_ * target_length / source_length);
    }
    Eigen::Affine3d bone(const Vector3d& source_start, const Vector3d& source_end, const Vector3d& target_start,
                         const Vector3d& target_end, const Eigen::Matrix3d& rotation) const
    {
        return bone_transform(source_start, source_end, target_start, target_end, rotation,
                              transverse_scale((source_end - source_start).norm(), (target_end - target_start).norm()));
    }

    void fit_leg();
    Eigen::Affine3d fit_foot() const;
    void fit_toes();
    std::vector<Vector3d> toe_tips(const Vector3d& forward, const Vector3d& outward) const;
    void fit_arm();
    void fit_forearm(const Vector3d& flexion_axis, const Vector3d& source_flexion_axis);
    void fit_hand(const Eigen::Matrix3d& hand_rotation);
    void fit_finger(const std::string& finger, Eigen::Matrix3d rotation);
    Vector3d finger_tip(const std::string& finger) const;

    const std::vector<AnatomyMesh>& parts_;
    const BonePoints& points_;
    const AxialMap& trunk_;
    const AnatomyTarget& target_;
    BodySide body_side_;
    std::string side_;  ///< its name
    double lateral_, stature_scale_ = 1.0;
    std::map<std::string, Eigen::Affine3d> transforms_;
};

/// Extents of points in a foot's own axes: forward, up, inward to outward.
struct FootBox {
    double heel = 1e9, tip = -1e9, inner = 1e9, outer = -1e9, sole = 1e9;
};

FootBox foot_box(const Points& vertices, const Vector3d& forward, const Vector3d& outward)
{
    FootBox box;
    const Eigen::VectorXd along = vertices * forward, across = vertices * outward;
    box.heel = along.minCoeff();
    box.tip = along.maxCoeff();
    box.sole = vertices.col(1).minCoeff();
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        const double share = (along[v] - box.heel) / (box.tip - box.heel);
        if (share < 0.6 || share > 0.8) continue;  // the ball, where a foot is broadest
        box.inner = std::min(box.inner, across[v]);
        box.outer = std::max(box.outer, across[v]);
    }
    return box;
}

Eigen::Affine3d LimbFit::fit_foot() const
{
    const auto horizontal = [](Vector3d v) {
        v[1] = 0;
        return Vector3d(v.normalized());
    };
    const Vector3d source_forward = horizontal(source("toes") - source("foot"));
    const Vector3d target_forward = horizontal(joint("toes") - joint("foot"));
    const auto outward = [&](const Vector3d& forward) { return Vector3d(lateral_ * Vector3d::UnitY().cross(forward)); };

    const double source_top = source("foot")[1], target_top = joint("foot")[1];
    std::vector<Vector3d> bones, skin;
    for (const AnatomyMesh& part : parts_) {
        if (part.layer != AnatomyLayer::bone || part.side != body_side_) continue;
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v)
            if (part.vertices(v, 1) < source_top) bones.emplace_back(part.vertices.row(v).transpose());
    }
    const Eigen::VectorXd weight = target_.region_weight({side_ + "_foot", side_ + "_toes"});
    for (Eigen::Index v = 0; v < weight.size(); ++v)
        if (weight[v] > 0.5 && target_.vertices(v, 1) < target_top)
            skin.emplace_back(target_.vertices.row(v).transpose());
    const auto to_points = [](const std::vector<Vector3d>& list) {
        Points result(static_cast<Eigen::Index>(list.size()), 3);
        for (std::size_t i = 0; i < list.size(); ++i) result.row(Eigen::Index(i)) = list[i].transpose();
        return result;
    };
    require(!bones.empty() && !skin.empty(), "the {} foot has no bones or no skin", side_);
    const FootBox from = foot_box(to_points(bones), source_forward, outward(source_forward));
    FootBox to = foot_box(to_points(skin), target_forward, outward(target_forward));
    // Soft tissue around the bones of the foot, m: heel pad and sole are the thickest.
    to.heel += 0.008;
    to.tip -= 0.004;
    to.inner += 0.005;
    to.outer -= 0.005;
    to.sole += 0.007;
    const Vector3d low_from(from.heel, from.sole, from.inner), high_from(from.tip, source_top, from.outer);
    const Vector3d low_to(to.heel, to.sole, to.inner), high_to(to.tip, target_top, to.outer);
    const Vector3d scale = (high_to - low_to).cwiseQuotient(high_from - low_from);
    Eigen::Matrix3d source_axes, target_axes;
    source_axes << source_forward, Vector3d::UnitY(), outward(source_forward);
    target_axes << target_forward, Vector3d::UnitY(), outward(target_forward);
    Eigen::Affine3d transform;
    transform.linear() = target_axes * scale.asDiagonal() * source_axes.transpose();
    transform.translation() = target_axes * (low_to - scale.cwiseProduct(low_from));
    return transform;
}

void LimbFit::fit_leg()
{
    const Eigen::Affine3d foot = fit_foot();
    const Vector3d hip = trunk_.trunk(source("thigh")), ankle = foot * source("foot");
    const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
    set("thigh", bone(source("thigh"), source("shin"), hip, joint("shin"), upright));
    set("shin", bone(source("shin"), source("foot"), joint("shin"), ankle, upright));
    set("foot", foot);
    fit_toes();
}

std::vector<Vector3d> LimbFit::toe_tips(const Vector3d& forward, const Vector3d& outward) const
{
    const Eigen::VectorXd weight = target_.region_weight({side_ + "_toes"});
    const Eigen::VectorXd along = target_.vertices * forward;
    const auto neighbours = vertex_neighbours(target_.triangles, int(target_.vertices.rows()));
    std::vector<Vector3d> tips;
    for (Eigen::Index v = 0; v < weight.size(); ++v) {
        if (weight[v] < 0.5) continue;
        // Foremost of everything within two edges.
        bool foremost = true;
        for (const int a : neighbours[std::size_t(v)])
            for (const int b : neighbours[std::size_t(a)])
                foremost = foremost && along[a] <= along[v] && along[b] <= along[v];
        if (foremost) tips.emplace_back(target_.vertices.row(v).transpose());
    }
    // The bulge of a nail can have a tip of its own: of tips closer than half a toe's breadth the foremost one stays.
    std::sort(tips.begin(), tips.end(),
              [&](const Vector3d& a, const Vector3d& b) { return a.dot(forward) > b.dot(forward); });
    constexpr double half_toe = 0.007;
    std::vector<Vector3d> apart;
    for (const Vector3d& tip : tips) {
        const bool near = std::any_of(apart.begin(), apart.end(), [&](const Vector3d& other) {
            return std::abs((tip - other).dot(outward)) < half_toe;
        });
        if (!near && apart.size() < 5) apart.push_back(tip);
    }
    std::sort(apart.begin(), apart.end(),
              [&](const Vector3d& a, const Vector3d& b) { return a.dot(outward) < b.dot(outward); });
    return apart;
}

void LimbFit::fit_toes()
{
    Vector3d forward = joint("toes") - joint("foot");
    forward[1] = 0;
    forward.normalize();
    const Vector3d outward = lateral_ * Vector3d::UnitY().cross(forward);
    const std::vector<Vector3d> tips = toe_tips(forward, outward);
    const Eigen::Affine3d& foot = get("foot");
    for (std::size_t k = 0; k < 5; ++k) {
        const std::string name = "toe_" + std::to_string(k + 1);
        if (tips.size() < 5) {  // a skin without toes of its own
            set(name, foot);
            continue;
        }
        const Vector3d start = foot * source(name), tip = tips[k] - toe_pulp * (tips[k] - start).normalized();
        const double length = (source(name + "_tip") - source(name)).norm();
        const double across = std::min(transverse_scale(length, (tip - start).norm()), stature_scale_);
        set(name,
            bone_transform(source(name), source(name + "_tip"), start, tip, rotation_part(foot.linear()), across));
    }
}

void LimbFit::fit_arm()
{
    const Vector3d upper = joint("forearm") - joint("upper_arm"), lower = joint("hand") - joint("forearm");
    const Vector3d source_upper = source("forearm") - source("upper_arm");
    // The axis about which bending turns the forearm forward, by the right-hand rule.
    const Vector3d source_flexion = lateral_ * (source("medial_epicondyle") - source("lateral_epicondyle"));
    Vector3d flexion = upper.normalized().cross(lower.normalized());
    constexpr double smallest_bend = 0.09;  // 5 degrees; a straighter arm does not tell its plane
    if (flexion.norm() < smallest_bend) flexion = minimal_rotation(source_upper, upper) * source_flexion;
    const Eigen::Matrix3d humerus_rotation =
        frame_along(upper, flexion) * frame_along(source_upper, source_flexion).transpose();
    set("upper_arm",
        bone(source("upper_arm"), source("forearm"), joint("upper_arm"), joint("forearm"), humerus_rotation));

    const auto elevation = [](const Vector3d& arm) { return std::acos(std::clamp(-arm.normalized()[1], -1.0, 1.0)); };
    const double upward = std::max(0.0, elevation(upper) - elevation(source_upper)) / 3.0;
    // Seen from the shoulder the blade lies where the ribs have gone, on the muscles between, which are not pressed.
    const Vector3d off_ribs(0.0, 0.0, -0.006);
    Vector3d blade = Vector3d::Zero();
    for (const AnatomyMesh& part : parts_)
        if (part.side == body_side_ && part.name.find("scapula") != std::string::npos &&
            part.layer == AnatomyLayer::bone)
            blade = part.vertices.colwise().mean().transpose();
    const Eigen::Matrix3d on_ribs =
        minimal_rotation(blade - source("upper_arm"), trunk_.trunk(blade) + off_ribs - joint("upper_arm"));
    Eigen::Affine3d scapula;
    scapula.linear() = stature_scale_ * about_z(lateral_ * upward) * on_ribs;
    scapula.translation() = joint("upper_arm") - scapula.linear() * source("upper_arm");
    set("scapula", scapula);
    set("clavicle", bone(source("clavicle"), source("acromion_end"), trunk_.trunk(source("clavicle")),
                         scapula * source("acromion_end"), Eigen::Matrix3d::Identity()));
    fit_forearm(flexion, source_flexion);
}

void LimbFit::fit_forearm(const Vector3d& flexion_axis, const Vector3d& source_flexion_axis)
{
    const std::vector<std::string> knuckles = {"hand", "index_1", "middle_1", "ring_1", "pinky_1"};
    Points from(static_cast<Eigen::Index>(knuckles.size()), 3), to(from.rows(), 3);
    for (std::size_t i = 0; i < knuckles.size(); ++i) {
        from.row(Eigen::Index(i)) = source(knuckles[i]).transpose();
        to.row(Eigen::Index(i)) = joint(knuckles[i]).transpose();
    }
    const Eigen::Matrix3d hand_rotation = rotation_part(fit_similarity(from, to).linear());
    const Vector3d forearm = joint("hand") - joint("forearm"), source_forearm = source("hand") - source("forearm");
    const Eigen::Matrix3d elbow_rotation =
        frame_along(forearm, flexion_axis) * frame_along(source_forearm, source_flexion_axis).transpose();
    const double scale = transverse_scale(source_forearm.norm(), forearm.norm());
    // Beside the wrist's centre the head of the ulna goes where the hand has turned to.
    const Vector3d ulnar_head = joint("hand") - scale * (hand_rotation * (source("hand") - source("ulnar_head")));
    set("ulna", bone(source("forearm"), source("ulnar_head"), joint("forearm"), ulnar_head, elbow_rotation));
    const Vector3d radial_head = get("ulna") * source("radial_head");
    const double pronation = twist_angle(hand_rotation * elbow_rotation.transpose(), forearm.normalized());
    const Eigen::Matrix3d radius_rotation =
        Eigen::AngleAxisd(pronation, forearm.normalized()).toRotationMatrix() * elbow_rotation;
    set("radius", bone(source("radial_head"), source("hand"), radial_head, joint("hand"), radius_rotation));
    fit_hand(hand_rotation);
}

void LimbFit::fit_hand(const Eigen::Matrix3d& hand_rotation)
{
    set("carpus", bone(source("hand"), source("middle_1"), joint("hand"), joint("middle_1"), hand_rotation));
    for (const char* finger : {"index", "middle", "ring", "pinky"}) {
        const std::string name(finger);
        const Vector3d base = get("carpus") * source(name + "_base");
        const Eigen::Affine3d metacarpal =
            bone(source(name + "_base"), source(name + "_1"), base, joint(name + "_1"), hand_rotation);
        set(name + "_0", metacarpal);
        fit_finger(name, rotation_part(metacarpal.linear()));
    }
    // The rig has the thumb's first joint further out than the saddle joint; half way keeps the bone inside the ball.
    const Vector3d base = 0.5 * (get("carpus") * source("thumb_1") + joint("thumb_1"));
    const Eigen::Affine3d metacarpal =
        bone(source("thumb_1"), source("thumb_2"), base, joint("thumb_2"), hand_rotation);
    set("thumb_0", metacarpal);
    fit_finger("thumb", rotation_part(metacarpal.linear()));
}

Vector3d LimbFit::finger_tip(const std::string& finger) const
{
    const Vector3d last = joint(finger + "_3"), direction = (last - joint(finger + "_2")).normalized();
    const Eigen::VectorXd weight = target_.region_weight({side_ + "_" + finger + "_3"});
    Vector3d tip = last;
    double farthest = 0.0;
    for (Eigen::Index v = 0; v < weight.size(); ++v) {
        const Vector3d offset = target_.vertices.row(v).transpose() - last;
        if (weight[v] < 0.5 || offset.dot(direction) <= farthest) continue;
        farthest = offset.dot(direction);
        tip = last + offset;
    }
    require(farthest > 0.0, "the skin has no tip of the {} {}", side_, finger);
    constexpr double pulp = 0.004;  // soft tissue at the end of a finger, m
    return tip - std::min(pulp, 0.5 * farthest) * direction;
}

void LimbFit::fit_finger(const std::string& finger, Eigen::Matrix3d rotation)
{
    const bool is_thumb = finger == "thumb";
    const int num_phalanges = is_thumb ? 2 : 3;
    for (int k = 1; k <= num_phalanges; ++k) {
        const std::string start = finger + "_" + std::to_string(is_thumb ? k + 1 : k);
        const bool last = k == num_phalanges;
        const std::string next = finger + "_" + std::to_string(is_thumb ? k + 2 : k + 1);
        const Vector3d source_end = last ? source(finger + "_tip") : source(next);
        const Vector3d target_end = last ? finger_tip(finger) : joint(next);
        const Eigen::Affine3d phalanx = bone(source(start), source_end, joint(start), target_end, rotation);
        set(finger + "_" + std::to_string(k), phalanx);
        rotation = rotation_part(phalanx.linear());
    }
}

}  // namespace

std::map<std::string, Eigen::Affine3d> limb_transforms(const std::vector<AnatomyMesh>& parts, const BonePoints& points,
                                                       const AxialMap& trunk, const AnatomyTarget& target)
{
    auto transforms = LimbFit(parts, points, trunk, target, BodySide::left).fit();
    transforms.merge(LimbFit(parts, points, trunk, target, BodySide::right).fit());
    return transforms;
}

}  // namespace ndg
