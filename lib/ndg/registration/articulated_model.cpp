// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/articulated_model.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace ndg {
namespace {

constexpr double radian = EIGEN_PI / 180.0;
/// Standard deviations of the logarithms of the parts' scales.
constexpr double length_deviation = 0.03, girth_deviation = 0.15, extremity_deviation = 0.05;
/// Joints follow the breadth and depth of a part of the trunk with this exponent: fat lies outside them.
constexpr double joint_share = 0.5;
constexpr double difference_step = 1e-5;
/// Share of an arm's turn that goes to the clavicle, in the prior's mean: between 45 and 120 degrees of elevation the
/// shoulder joint's centre rises by some 2.8 cm (from the bone-pin means of Ludewig et al. 2009), 15 cm beside the
/// clavicle's own joint.
constexpr double clavicle_share = 0.15;

std::vector<int> all_rows(Eigen::Index count)
{
    std::vector<int> rows(count);
    std::iota(rows.begin(), rows.end(), 0);
    return rows;
}

/// Weighted sum of the joints' motions of one row.
template <typename Motion>
Eigen::Vector3d blend(const SkinningWeights& weights, int row, const Motion& motion)
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < max_influences; ++k) {
        const double weight = weights.weights(row, k);
        if (weight > 0) sum += weight * motion(static_cast<std::size_t>(weights.joints(row, k)));
    }
    return sum;
}

}  // namespace

/// What the parameters make of offsets from a joint.
class ArticulatedModel::Scale {
public:
    Scale(const JointPart& joint, PartKind kind, const Eigen::VectorXd& logarithms, double overall) : joint_(&joint)
    {
        const Eigen::VectorXd factors = overall * logarithms.array().exp().matrix();
        is_limb_ = kind == PartKind::limb;
        if (kind == PartKind::trunk) {
            flesh_ = factors;
            bone_ = Eigen::Vector3d(overall * std::exp(joint_share * logarithms[0]), factors[1],
                                    overall * std::exp(joint_share * logarithms[2]));
        } else if (kind == PartKind::whole) {
            flesh_ = bone_ = Eigen::Vector3d::Constant(factors[0]);
        } else {
            bone_ = Eigen::Vector3d::Constant(factors[0]);
            begin_ = logarithms[1];
            change_ = logarithms[2] - logarithms[1];
            overall_ = overall;
        }
    }
    /// From this joint to the next one.
    Eigen::Vector3d bone(const Eigen::Vector3d& offset) const { return bone_.cwiseProduct(offset); }
    /// From this joint to a skin vertex of the template.
    Eigen::Vector3d flesh(const Eigen::Vector3d& vertex, const Eigen::Vector3d& offset) const
    {
        if (!is_limb_) return flesh_.cwiseProduct(offset);
        const double share = std::clamp((vertex - joint_->origin).dot(joint_->direction) / joint_->length, 0.0, 1.0);
        const double across = overall_ * std::exp(begin_ + share * change_);
        return across * offset + (bone_[0] - across) * offset.dot(joint_->direction) * joint_->direction;
    }

private:
    const JointPart* joint_;
    bool is_limb_ = false;
    Eigen::Vector3d flesh_ = Eigen::Vector3d::Ones(), bone_ = Eigen::Vector3d::Ones();
    double begin_ = 0.0, change_ = 0.0, overall_ = 1.0;
};

void ArticulatedModel::add_turn(const std::vector<std::string>& joints, double degrees_across, double degrees_along,
                                const Eigen::Vector3d& axis, std::vector<Eigen::Matrix3d>& priors)
{
    Turn turn;
    for (const std::string& joint : joints) turn.joints.push_back(standard_skeleton().joint(joint));
    turn.parameter = rotation_begin() + 3 * static_cast<int>(turns_.size());
    turns_.push_back(std::move(turn));
    const Eigen::Matrix3d along = axis * axis.transpose();
    priors.push_back(along / (degrees_along * radian) +
                     (Eigen::Matrix3d::Identity() - along) / (degrees_across * radian));
}

ArticulatedModel::ArticulatedModel(SkinnedSurface skin) : skin_(std::move(skin))
{
    const Skeleton& skeleton = standard_skeleton();
    require(skin_.joint_positions.rows() == skeleton.num_joints(), "the skin has {} joints instead of {}",
            skin_.joint_positions.rows(), skeleton.num_joints());
    const auto joint_count = static_cast<std::size_t>(skeleton.num_joints());

    // Parts, and where their bones end. Joints not named go with their parent.
    struct PartRow {
        PartKind kind;
        std::vector<std::string> joints;
        std::string end;
    };
    const std::vector<PartRow> rows = {{PartKind::trunk, {"pelvis"}, ""},
                                       {PartKind::trunk, {"spine_1", "spine_2"}, ""},
                                       {PartKind::trunk, {"spine_3", "spine_4"}, ""},
                                       {PartKind::trunk, {"spine_5"}, ""},
                                       {PartKind::limb, {"neck_1", "neck_2"}, "head"},
                                       {PartKind::whole, {"head"}, ""},
                                       {PartKind::limb, {"upper_arm"}, "forearm"},
                                       {PartKind::limb, {"forearm", "forearm_twist"}, "hand"},
                                       {PartKind::whole, {"hand"}, ""},
                                       {PartKind::limb, {"thigh"}, "shin"},
                                       {PartKind::limb, {"shin"}, "foot"},
                                       {PartKind::whole, {"foot"}, ""}};
    const auto sided = [](const std::string& name, const std::string& side) {
        const bool middle =
            name == "pelvis" || name == "head" || name.rfind("spine", 0) == 0 || name.rfind("neck", 0) == 0;
        return middle ? name : side + name;
    };
    joint_parts_.resize(joint_count);
    int num_scales = 0;
    for (std::size_t p = 0; p < rows.size(); ++p) {
        parts_.push_back({rows[p].kind, num_scales});
        num_scales += parts_.back().num_parameters();
        for (const std::string side : {"left_", "right_"}) {
            JointPart part;
            part.part = static_cast<int>(p);
            part.origin = skin_.joint_positions.row(skeleton.joint(sided(rows[p].joints.front(), side))).transpose();
            if (!rows[p].end.empty()) {
                const Eigen::Vector3d bone =
                    skin_.joint_positions.row(skeleton.joint(sided(rows[p].end, side))).transpose() - part.origin;
                part.length = bone.norm();
                part.direction = bone / part.length;
            }
            for (const std::string& joint : rows[p].joints) {
                joint_parts_[skeleton.joint(sided(joint, side))] = part;
            }
        }
    }
    for (std::size_t j = 0; j < joint_count; ++j) {
        if (joint_parts_[j].part < 0) joint_parts_[j] = joint_parts_[skeleton.parents[j]];
    }

    std::vector<Eigen::Matrix3d> priors;
    const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
    add_turn({"spine_1", "spine_2", "spine_3"}, 8.0, 5.0, up, priors);
    add_turn({"spine_4", "spine_5"}, 5.0, 4.0, up, priors);
    add_turn({"neck_1", "neck_2", "head"}, 12.0, 8.0, up, priors);
    for (const std::string side : {"left_", "right_"}) {
        const auto axis = [&](const std::string& joint) {
            return joint_parts_[skeleton.joint(side + joint)].direction;
        };
        // A surface says little of a limb's twist about its own bone.
        add_turn({side + "clavicle"}, 4.0, 2.0, Eigen::Vector3d::UnitX(), priors);
        add_turn({side + "upper_arm"}, 25.0, 6.0, axis("upper_arm"), priors);
        add_turn({side + "forearm"}, 20.0, 3.0, axis("forearm"), priors);
        add_turn({side + "hand"}, 10.0, 6.0, axis("forearm"), priors);
        add_turn({side + "thigh"}, 15.0, 6.0, axis("thigh"), priors);
        add_turn({side + "shin"}, 12.0, 2.0, axis("shin"), priors);
        add_turn({side + "foot"}, 10.0, 6.0, axis("shin"), priors);
    }
    scale_begin_ = rotation_begin() + 3 * static_cast<int>(turns_.size());
    prior_ = Eigen::MatrixXd::Zero(scale_begin_ + num_scales, scale_begin_ + num_scales);
    for (std::size_t t = 0; t < turns_.size(); ++t) {
        prior_.block<3, 3>(turns_[t].parameter, turns_[t].parameter) = priors[t];
    }
    for (const std::string side : {"left_", "right_"}) {
        const int clavicle = turn_parameter(side + "clavicle"), arm = turn_parameter(side + "upper_arm");
        prior_.block<3, 3>(clavicle, arm) =
            -clavicle_share / (1.0 - clavicle_share) * prior_.block<3, 3>(clavicle, clavicle);
    }
    for (Part& part : parts_) {
        part.parameter += scale_begin_;
        const int length = part.kind == PartKind::trunk ? 1 : part.kind == PartKind::limb ? 0 : -1;
        for (int k = 0; k < part.num_parameters(); ++k) {
            const double deviation = length < 0    ? extremity_deviation
                                     : k == length ? length_deviation
                                                   : girth_deviation;
            prior_(part.parameter + k, part.parameter + k) = 1.0 / deviation;
        }
    }
}

int ArticulatedModel::turn_parameter(const std::string& joint) const
{
    const std::vector<int> wanted = {standard_skeleton().joint(joint)};
    const auto found =
        std::find_if(turns_.begin(), turns_.end(), [&](const Turn& turn) { return turn.joints == wanted; });
    require(found != turns_.end(), "{} does not turn alone", joint);
    return found->parameter;
}

Eigen::VectorXd ArticulatedModel::with_arms(const Eigen::Vector3d& left_direction) const
{
    Eigen::VectorXd parameters = Eigen::VectorXd::Zero(num_parameters());
    for (const double x : {1.0, -1.0}) {
        const std::string side = x > 0 ? "left_" : "right_";
        const Eigen::Vector3d bone = joint_parts_[standard_skeleton().joint(side + "upper_arm")].direction;
        const Eigen::AngleAxisd turn(
            minimal_rotation(bone, Eigen::Vector3d(x, 1.0, 1.0).cwiseProduct(left_direction).normalized()));
        const Eigen::Vector3d vector = turn.angle() * turn.axis();
        parameters.segment<3>(turn_parameter(side + "clavicle")) = clavicle_share * vector;
        parameters.segment<3>(turn_parameter(side + "upper_arm")) = (1.0 - clavicle_share) * vector;
    }
    return parameters;
}

std::vector<ArticulatedModel::Scale> ArticulatedModel::joint_scales(const Eigen::VectorXd& parameters) const
{
    std::vector<Scale> scales;
    for (const JointPart& joint : joint_parts_) {
        const Part& part = parts_[joint.part];
        scales.emplace_back(joint, part.kind, parameters.segment(part.parameter, part.num_parameters()),
                            std::exp(parameters[6]));
    }
    return scales;
}

Points ArticulatedModel::rest_joints(const Eigen::VectorXd& parameters) const
{
    const auto scales = joint_scales(parameters);
    const auto& parents = standard_skeleton().parents;
    Points joints = skin_.joint_positions;
    for (std::size_t j = 1; j < scales.size(); ++j) {
        const auto row = static_cast<Eigen::Index>(j), parent = static_cast<Eigen::Index>(parents[j]);
        const Eigen::Vector3d bone = (skin_.joint_positions.row(row) - skin_.joint_positions.row(parent)).transpose();
        joints.row(row) = joints.row(parent) + scales[parent].bone(bone).transpose();
    }
    return joints;
}

Points ArticulatedModel::rest_vertices(const Eigen::VectorXd& parameters, const std::vector<int>& rows) const
{
    const std::vector<int>& wanted = rows.empty() ? all_rows(skin_.vertices.rows()) : rows;
    const auto scales = joint_scales(parameters);
    const Points joints = rest_joints(parameters);
    Points result(static_cast<Eigen::Index>(wanted.size()), 3);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const Eigen::Vector3d vertex = skin_.vertices.row(wanted[i]).transpose();
        result.row(static_cast<Eigen::Index>(i)) =
            blend(skin_.weights, wanted[i], [&](std::size_t j) -> Eigen::Vector3d {
                const auto row = static_cast<Eigen::Index>(j);
                return joints.row(row).transpose() +
                       scales[j].flesh(vertex, vertex - skin_.joint_positions.row(row).transpose());
            }).transpose();
    }
    return result;
}

Pose ArticulatedModel::pose(const Eigen::VectorXd& parameters) const
{
    Pose result = Pose::rest(standard_skeleton().num_joints());
    result.parent_from_joint[0] = rotation_of(parameters.head<3>());
    result.root_translation = parameters.segment<3>(3);
    for (const Turn& turn : turns_) {
        const Eigen::Vector3d share = parameters.segment<3>(turn.parameter) / static_cast<double>(turn.joints.size());
        for (const int j : turn.joints) result.parent_from_joint[j] = rotation_of(share);
    }
    return result;
}

Points ArticulatedModel::posed_vertices(const Eigen::VectorXd& parameters, const std::vector<int>& rows) const
{
    const std::vector<int>& wanted = rows.empty() ? all_rows(skin_.vertices.rows()) : rows;
    const auto world_from_rest = forward_kinematics(standard_skeleton(), rest_joints(parameters), pose(parameters));
    Points result = rest_vertices(parameters, wanted);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const Eigen::Vector3d rest = result.row(static_cast<Eigen::Index>(i)).transpose();
        result.row(static_cast<Eigen::Index>(i)) =
            blend(skin_.weights, wanted[i], [&](std::size_t j) -> Eigen::Vector3d {
                return world_from_rest[j] * rest;
            }).transpose();
    }
    return result;
}

Eigen::MatrixXd ArticulatedModel::jacobian(const Eigen::VectorXd& parameters, const std::vector<int>& rows) const
{
    Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(rows.size()), num_parameters());
#pragma omp parallel for schedule(dynamic, 1)
    for (int p = 0; p < num_parameters(); ++p) {
        Eigen::VectorXd moved = parameters;
        moved[p] = parameters[p] + difference_step;
        const Points after = posed_vertices(moved, rows);
        moved[p] = parameters[p] - difference_step;
        const Points before = posed_vertices(moved, rows);
        const Points difference = (after - before) / (2.0 * difference_step);
        result.col(p) = Eigen::Map<const Eigen::VectorXd>(difference.data(), difference.size());
    }
    return result;
}

}  // namespace ndg
