// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/weights.h"

#include "ndg/body/skeleton.h"
#include "ndg/body/skinning.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/procedural/skin.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

namespace ndg {

namespace {

constexpr int smoothing_steps = 5;
constexpr double negligible_share = 1e-4;

/// 0 below -1, 1 above 1, smooth in between.
double ramp(double t)
{
    const double s = std::clamp(0.5 * (t + 1.0), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

/// A joint of a chain: the bone before it hands over to it across a plane, over `half_width` on both sides.
struct Handover {
    int joint;
    Eigen::Vector3d point, direction;
    double half_width;
};

/// Adds `share`, divided over the chain; the first entry's plane is not used.
void add_chain(const std::vector<Handover>& chain, const Eigen::Vector3d& x, double share,
               Eigen::Ref<Eigen::RowVectorXd> weights)
{
    double left = 1.0;
    for (std::size_t i = 0; i < chain.size(); ++i) {
        double next = 0.0;
        if (i + 1 < chain.size()) {
            const Handover& h = chain[i + 1];
            next = std::min(left, ramp((x - h.point).dot(h.direction) / h.half_width));
        }
        weights[chain[i].joint] += share * (left - next);
        left = next;
    }
}

/// The chains of the left side and the middle.
class Chains {
public:
    explicit Chains(const BodyLayout& layout) : layout_(layout), u_(layout.unit())
    {
        const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
        spine_ = {{id("pelvis"), {}, up, 1.0}};
        for (const char* name : {"spine_1", "spine_2", "spine_3", "spine_4", "spine_5"})
            spine_.push_back({id(name), layout.joint(name), up, 0.042 * u_});
        neck_ = spine_;
        const Eigen::Vector3d neck = (layout.joint("head") - layout.joint("neck_1")).normalized();
        neck_.push_back({id("neck_1"), layout.joint("neck_1"), neck, 0.030 * u_});
        neck_.push_back({id("neck_2"), layout.joint("neck_2"), neck, 0.026 * u_});
        neck_.push_back({id("head"), layout.joint("head"), neck, 0.028 * u_});
        const Eigen::Vector3d arm = layout.arm_axis();
        arm_ = {{id("left_clavicle"), {}, arm, 1.0},
                {id("left_upper_arm"), layout.joint("left_upper_arm") + 0.005 * u_ * arm, arm, 0.055 * u_},
                {id("left_forearm"), layout.joint("left_forearm"), arm, 0.045 * u_},
                {id("left_forearm_twist"), layout.joint("left_forearm_twist"), arm, 0.070 * u_},
                {id("left_hand"), layout.joint("left_hand"), arm, 0.024 * u_}};
        const Eigen::Vector3d thigh = (layout.joint("left_shin") - layout.joint("left_thigh")).normalized();
        const Eigen::Vector3d foot = (0.55 * layout.leg_axis() + 0.83 * layout.foot_front()).normalized();
        leg_ = {{id("pelvis"), {}, thigh, 1.0},
                {id("left_thigh"), layout.joint("left_thigh") + 0.010 * u_ * thigh, thigh, 0.085 * u_},
                {id("left_shin"), layout.joint("left_shin"), layout.leg_axis(), 0.060 * u_},
                {id("left_foot"), layout.joint("left_foot"), foot, 0.036 * u_},
                {id("left_toes"), layout.joint("left_toes"), layout.foot_front(), 0.018 * u_}};
        for (int f = 0; f < 5; ++f) {
            const Points p = finger_points(layout, f);
            std::vector<Handover>& chain = fingers_[f];
            chain.push_back(arm_[3]);
            chain.push_back(arm_[4]);
            for (int k = 0; k < 3; ++k)
                chain.push_back({id(std::string("left_") + finger_plan(f).name + "_" + std::to_string(k + 1)),
                                 p.row(k).transpose(), (p.row(k + 1) - p.row(k)).transpose().normalized(),
                                 (k == 0 ? 0.012 : 0.0075) * u_});
        }
    }

    /// Weights of a point by a part's chain.
    void add(int part, const Eigen::Vector3d& x, double share, Eigen::Ref<Eigen::RowVectorXd> weights) const
    {
        if (part == skin_trunk || part == skin_neck) {
            // Shoulder girdle: from beside the breastbone out to the shoulder, above the chest.
            const Eigen::Vector3d shoulder = layout_.joint("left_upper_arm");
            const double girdle = 0.85 * ramp((x.x() - 0.62 * shoulder.x()) / (0.32 * shoulder.x())) *
                                  ramp((x.y() - layout_.height(1.315)) / (0.065 * u_));
            weights[id("left_clavicle")] += share * girdle;
            add_chain(neck_, x, share * (1.0 - girdle), weights);
        } else if (part == skin_head) {
            const double jaw =
                ramp((layout_.height(1.526) - x.y()) / (0.010 * u_)) * ramp((x.z() - 0.045 * u_) / (0.035 * u_));
            weights[id("jaw")] += share * jaw;
            weights[id("head")] += share * (1.0 - jaw);
        } else if (part == skin_arm || part == skin_palm) {
            add_chain(arm_, x, share, weights);
        } else if (part == skin_leg || part == skin_foot) {
            add_chain(leg_, x, share, weights);
        } else {
            add_chain(fingers_[part - skin_finger_0], x, share, weights);
        }
    }

private:
    static int id(const std::string& name) { return standard_skeleton().joint(name); }

    const BodyLayout& layout_;
    double u_;
    std::vector<Handover> spine_, neck_, arm_, leg_;
    std::array<std::vector<Handover>, 5> fingers_;
};

/// A joint's bone ends at this one.
std::string bone_end(const std::string& joint)
{
    static const std::array<std::array<const char*, 2>, 17> ends = {{{"pelvis", "spine_1"},
                                                                     {"spine_1", "spine_2"},
                                                                     {"spine_2", "spine_3"},
                                                                     {"spine_3", "spine_4"},
                                                                     {"spine_4", "spine_5"},
                                                                     {"spine_5", "neck_1"},
                                                                     {"neck_1", "neck_2"},
                                                                     {"neck_2", "head"},
                                                                     {"clavicle", "upper_arm"},
                                                                     {"upper_arm", "forearm"},
                                                                     {"forearm", "hand"},
                                                                     {"forearm_twist", "hand"},
                                                                     {"hand", "middle_1"},
                                                                     {"thigh", "shin"},
                                                                     {"shin", "foot"},
                                                                     {"foot", "toes"},
                                                                     {"", ""}}};
    const bool left = joint.rfind("left_", 0) == 0, right = joint.rfind("right_", 0) == 0;
    const std::string side = left ? "left_" : right ? "right_" : "", plain = joint.substr(side.size());
    for (const auto& [begin, end] : ends)
        if (plain == begin && !plain.empty()) return side + end;
    if ((left || right) && (plain.back() == '1' || plain.back() == '2'))  // fingers
        return joint.substr(0, joint.size() - 1) + static_cast<char>(joint.back() + 1);
    return "";
}

int mirrored_joint(int joint)
{
    const Skeleton& skeleton = standard_skeleton();
    const std::string& name = skeleton.joint_names[joint];
    if (name.rfind("left_", 0) == 0) return skeleton.joint("right_" + name.substr(5));
    if (name.rfind("right_", 0) == 0) return skeleton.joint("left_" + name.substr(6));
    return joint;
}

}  // namespace

RowMatrix procedural_weights(const BodyLayout& layout, const Field& field, const SymmetricSurface& surface)
{
    const Chains chains(layout);
    const Skeleton& skeleton = standard_skeleton();
    RowMatrix weights = RowMatrix::Zero(surface.vertices.rows(), num_standard_joints);
    std::vector<int> mirror_joint;
    for (int j = 0; j < skeleton.num_joints(); ++j) mirror_joint.push_back(mirrored_joint(j));
    constexpr int num_parts = skin_finger_0 + 5;
#pragma omp parallel for schedule(dynamic, 256)
    for (int v = 0; v < surface.num_half; ++v) {
        const Eigen::Vector3d x = surface.vertices.row(v).transpose();
        std::array<double, num_parts> shares{};
        double nearest = 1.0, sum = 0.0;
        for (int part = 0; part < num_parts; ++part) {
            shares[part] = field.part_value(part, x);
            nearest = std::min(nearest, shares[part]);
        }
        for (int part = 0; part < num_parts; ++part) {
            const double reach = (part >= skin_finger_0 ? 0.0025 : part == skin_palm ? 0.004 : 0.012) * layout.unit();
            double& share = shares[part];
            share = std::exp(-(share - nearest) / reach);
            if (share < 1e-3) share = 0.0;
            sum += share;
        }
        for (int part = 0; part < num_parts; ++part)
            if (shares[part] > 0.0) chains.add(part, x, shares[part] / sum, weights.row(v));
        if (v < surface.num_middle) {
            const Eigen::RowVectorXd one_sided = weights.row(v);
            for (int j = 0; j < num_standard_joints; ++j)
                weights(v, j) = 0.5 * (one_sided[j] + one_sided[mirror_joint[j]]);
        }
    }
    const auto complete = [&] {
        for (int v = surface.num_middle; v < surface.num_half; ++v)
            for (int j = 0; j < num_standard_joints; ++j)
                weights(v + surface.num_half - surface.num_middle, mirror_joint[j]) = weights(v, j);
    };
    complete();
    const auto neighbours = vertex_neighbours(surface.triangles, static_cast<int>(surface.vertices.rows()));
    for (int step = 0; step < smoothing_steps; ++step) {
        RowMatrix smoothed = weights;
#pragma omp parallel for schedule(dynamic, 256)
        for (int v = 0; v < surface.num_half; ++v) {
            Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(weights.cols());
            for (const int n : neighbours[v]) mean += weights.row(n);
            smoothed.row(v) = 0.5 * weights.row(v) + 0.5 * mean / static_cast<double>(neighbours[v].size());
        }
        weights = smoothed;
        complete();
    }
    // The eight largest, without the negligible; of equal entries all stay or none, so that the middle stays symmetric.
    for (int v = 0; v < surface.num_half; ++v) {
        std::array<double, num_standard_joints> sorted{};
        for (int j = 0; j < num_standard_joints; ++j) sorted[j] = weights(v, j);
        std::sort(sorted.begin(), sorted.end(), std::greater<double>());
        const double least = std::max(negligible_share, sorted[max_influences] * (1.0 + 1e-9));
        for (int j = 0; j < num_standard_joints; ++j)
            if (weights(v, j) < least) weights(v, j) = 0.0;
        weights.row(v) /= weights.row(v).sum();
    }
    complete();
    return weights;
}

Points carry_points(const BodyLayout& from, const BodyLayout& to, const Eigen::Ref<const RowMatrix>& weights,
                    const Eigen::Ref<const Points>& points)
{
    const Skeleton& skeleton = standard_skeleton();
    // Hands, feet and head keep their forms: they are scaled as wholes.
    const auto scale_across = [&](const std::string& name) {
        const auto among = [&](std::initializer_list<const char*> words) {
            return std::any_of(words.begin(), words.end(),
                               [&](const char* word) { return name.find(word) != std::string::npos; });
        };
        if (among({"hand", "thumb", "index", "middle", "ring", "pinky"})) return to.hand_scale() / from.hand_scale();
        if (among({"foot", "toes"})) return to.foot_scale() / from.foot_scale();
        if (among({"head", "jaw", "eye"})) return to.head_scale() / from.head_scale();
        return to.unit() / from.unit();
    };
    std::vector<Eigen::Affine3d> motions;
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[j];
        const std::string end = bone_end(name);
        const double across = scale_across(name);
        const Eigen::Vector3d a = from.joints().row(j).transpose(), b = to.joints().row(j).transpose();
        Eigen::Matrix3d linear = across * Eigen::Matrix3d::Identity();
        if (!end.empty()) {
            const Eigen::Vector3d bone_a = from.joint(end) - a, bone_b = to.joint(end) - b;
            const Eigen::Vector3d d = bone_a.normalized();
            linear =
                Eigen::Quaterniond::FromTwoVectors(bone_a, bone_b).toRotationMatrix() *
                (across * Eigen::Matrix3d::Identity() + (bone_b.norm() / bone_a.norm() - across) * d * d.transpose());
        } else if (skeleton.parents[j] >= 0) {
            // An end bone keeps its parent's rotation; its own length is not known.
            const Eigen::Matrix3d parent = motions[skeleton.parents[j]].linear();
            const Eigen::JacobiSVD<Eigen::Matrix3d> svd(parent, Eigen::ComputeFullU | Eigen::ComputeFullV);
            linear = across * svd.matrixU() * svd.matrixV().transpose();
        }
        Eigen::Affine3d motion;
        motion.linear() = linear;
        motion.translation() = b - linear * a;
        motions.push_back(motion);
    }
    Points carried(points.rows(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const Eigen::Vector3d x = points.row(v).transpose();
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int j = 0; j < num_standard_joints; ++j)
            if (weights(v, j) > 0.0) sum += weights(v, j) * (motions[j] * x);
        carried.row(v) = sum.transpose();
    }
    return carried;
}

}  // namespace ndg
