// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/spine.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// Ranges of each level in degrees: flexion with extension, turning to one side, leaning to one side. White and Panjabi
/// 1990, representative values. Those of the lumbar spine are shared out anew as in the model of Christophy et al. 2012
/// (flexion 0.255, 0.231, 0.204, 0.185, 0.125; turning 0.169, 0.182, 0.221, 0.221, 0.208; leaning 0.188, 0.250, 0.245,
/// 0.181, 0.136 from L1-L2 down). Only their proportions within a few levels count.
constexpr std::array<std::array<double, 3>, num_spine_levels> level_ranges = {{
    {9.3, 1.9, 3.9}, {13.7, 2.0, 5.2}, {15.1, 2.0, 7.1}, {17.1, 1.6, 7.3}, {18.9, 1.5, 5.5},  // L5-S1 to L1-L2
    {12, 2, 8},      {12, 2, 9},       {9, 2, 7},        {6, 4, 6},        {6, 6, 6},         // T12-L1 to T8-T9
    {6, 6, 6},       {5, 6, 6},        {4, 8, 6},        {4, 8, 6},        {4, 8, 6},         // T7-T8 to T3-T4
    {4, 8, 6},       {4, 9, 5},        {9, 2, 4},        {17, 6, 7},       {20, 7, 8},        // T2-T3 to C5-C6
    {20, 7, 11},     {15, 7, 11},      {10, 3, 10},      {20, 40, 5},      {25, 5, 5},        // C4-C5 to C0-C1
}};

constexpr int turning = 1;  ///< the axis along the spine

/// Length along the polyline at which each of its points lies.
Eigen::VectorXd places_along(const Points& line)
{
    Eigen::VectorXd places = Eigen::VectorXd::Zero(line.rows());
    for (Eigen::Index i = 1; i < line.rows(); ++i) places[i] = places[i - 1] + (line.row(i) - line.row(i - 1)).norm();
    return places;
}

/// Place on the polyline, continued straight beyond its ends, that is nearest to a point.
double nearest_place(const Points& line, const Eigen::VectorXd& places, const Eigen::RowVector3d& point)
{
    double best = places[0], least = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i + 1 < line.rows(); ++i) {
        const Eigen::RowVector3d edge = line.row(i + 1) - line.row(i);
        const double low = i == 0 ? -10.0 : 0.0, high = i + 2 == line.rows() ? 10.0 : 1.0;
        const double share = std::clamp((point - line.row(i)).dot(edge) / edge.squaredNorm(), low, high);
        const double distance = (line.row(i) + share * edge - point).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        best = places[i] + share * edge.norm();
    }
    return best;
}

/// Shares of one joint's turn about one axis: range times a hat between the neighbouring joints, times exp(tilt * s)
/// with the tilt that puts the mean place at the joint (as near as the levels allow). Turning about the spine's own
/// axis moves nothing along it and needs no tilt: half of the head's turn stays between axis and atlas.
Eigen::VectorXd balanced_shares(const Eigen::VectorXd& places, double before, double at, double after, int axis)
{
    Eigen::VectorXd base(places.size());
    for (Eigen::Index i = 0; i < places.size(); ++i) {
        const double s = places[i];
        const double hat = s <= at ? (s - before) / (at - before) : (after - s) / (after - at);
        base[i] = std::max(hat, 0.0) * level_ranges[std::size_t(i)][std::size_t(axis)];
    }
    if (base.sum() <= 0.0) {  // no level between the joints: the nearest takes all
        Eigen::Index nearest = 0;
        (places.array() - at).abs().minCoeff(&nearest);
        return Eigen::VectorXd::Unit(places.size(), nearest);
    }
    if (axis == turning) return base / base.sum();
    const double scale = after - before;
    const auto tilted = [&](double tilt) -> Eigen::VectorXd {
        Eigen::VectorXd shares = base.array() * (tilt * (places.array() - at) / scale).exp();
        return shares / shares.sum();
    };
    double low = -60.0, high = 60.0;
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        (tilted(middle).dot(places) < at ? low : high) = middle;
    }
    return tilted(0.5 * (low + high));
}

}  // namespace

SpineMotion::SpineMotion(const Eigen::Ref<const Points>& joint_positions, const Eigen::Ref<const Points>& levels,
                         const Eigen::Ref<const Points>& centres)
    : levels_(levels), centres_(centres)
{
    const Skeleton& skeleton = standard_skeleton();
    require(levels.rows() == num_spine_levels && centres.rows() == num_vertebrae &&
                joint_positions.rows() == skeleton.num_joints(),
            "the motion of a spine needs {} levels, {} vertebrae and {} joints, not {}, {} and {}", num_spine_levels,
            num_vertebrae, skeleton.num_joints(), levels.rows(), centres.rows(), joint_positions.rows());
    for (const char* name :
         {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5", "neck_1", "neck_2", "head"})
        joints_.push_back(skeleton.joint(name));

    const Eigen::VectorXd places = places_along(levels_);
    std::vector<double> at;  // of the joints from spine_1 on
    for (std::size_t k = 1; k < joints_.size(); ++k) {
        const double place = nearest_place(levels_, places, joint_positions.row(joints_[k]));
        at.push_back(at.empty() ? place : std::max(place, at.back() + 1e-3));
    }
    const std::size_t count = at.size();
    for (std::size_t k = 0; k < count; ++k) {
        // The outermost joints reach as far outwards as inwards.
        const double before = k == 0 ? 2.0 * at[0] - at[1] : at[k - 1];
        const double after = k + 1 == count ? 2.0 * at[k] - at[k - 1] : at[k + 1];
        Eigen::Matrix<double, num_spine_levels, 3> shares;
        for (int axis = 0; axis < 3; ++axis) shares.col(axis) = balanced_shares(places, before, at[k], after, axis);
        shares_.push_back(shares);
        for (int i = 1; i < num_spine_levels; ++i) shares.row(i) += shares.row(i - 1);
        shares.row(num_spine_levels - 1).setOnes();
        summed_.push_back(shares);
    }

    centre_places_.resize(num_vertebrae);
    for (int i = 0; i < num_vertebrae; ++i) centre_places_[i] = nearest_place(levels_, places, centres_.row(i));
    for (std::size_t k = 0; k + 1 < count; ++k) {  // half-way between two joints the skeleton is rigid
        Eigen::Index vertebra = 0;
        (centre_places_.array() - 0.5 * (at[k] + at[k + 1])).abs().minCoeff(&vertebra);
        if (!anchors_.empty() && anchors_.back().vertebra == int(vertebra)) continue;
        anchors_.push_back({centre_places_[vertebra], int(vertebra), joints_[k + 1]});
    }
    anchors_.push_back({places[num_spine_levels - 1], num_vertebrae, joints_.back()});
}

std::array<Eigen::Isometry3d, num_vertebrae> SpineMotion::vertebrae(const std::vector<Eigen::Isometry3d>& joints) const
{
    std::vector<Eigen::Vector3d> turns;  // of each joint in the frame of the one below it
    for (std::size_t k = 1; k < joints_.size(); ++k)
        turns.push_back(rotation_vector(joints[joints_[k - 1]].linear().transpose() * joints[joints_[k]].linear()));

    std::array<Eigen::Isometry3d, num_vertebrae> motions;
    Eigen::Isometry3d below = joints[joints_.front()];
    for (int i = 0; i < num_vertebrae; ++i) {
        Eigen::Matrix3d rotation = joints[joints_.front()].linear();
        for (std::size_t k = 0; k < turns.size(); ++k)
            rotation = rotation * rotation_of(summed_[k].row(i).transpose().cwiseProduct(turns[k]));
        const Eigen::Vector3d level = levels_.row(i).transpose();
        motions[std::size_t(i)].linear() = rotation;
        motions[std::size_t(i)].translation() = below * level - rotation * level;
        motions[std::size_t(i)].makeAffine();
        below = motions[std::size_t(i)];
    }

    std::vector<Eigen::Vector3d> left;  // from the chain to the skeleton, at the anchors
    for (const Anchor& anchor : anchors_) {
        const bool top = anchor.vertebra == num_vertebrae;
        const Eigen::Vector3d point = (top ? levels_.row(num_vertebrae) : centres_.row(anchor.vertebra)).transpose();
        left.push_back(joints[anchor.joint] * point -
                       motions[std::size_t(top ? num_vertebrae - 1 : anchor.vertebra)] * point);
    }
    for (int i = 0; i < num_vertebrae; ++i) {
        const double s = centre_places_[i];
        double before = 0.0;
        Eigen::Vector3d from = Eigen::Vector3d::Zero(), shift = left.back();
        for (std::size_t a = 0; a < anchors_.size(); ++a) {
            if (s <= anchors_[a].place) {
                const double share = std::clamp((s - before) / std::max(anchors_[a].place - before, 1e-9), 0.0, 1.0);
                shift = from + share * (left[a] - from);
                break;
            }
            before = anchors_[a].place;
            from = left[a];
        }
        motions[std::size_t(i)].translation() += shift;
    }
    return motions;
}

Points spine_levels(const std::vector<Points>& vertebrae, const Eigen::Vector3d& head_joint, Points& centres)
{
    require(vertebrae.size() == std::size_t(num_vertebrae), "{} vertebrae were given instead of {}", vertebrae.size(),
            num_vertebrae);
    constexpr double front_share = 0.45;  // of a vertebra's depth that is its body, about
    centres.resize(num_vertebrae, 3);
    for (int i = 0; i < num_vertebrae; ++i) {
        const Points& points = vertebrae[std::size_t(i)];
        const double front = points.col(2).maxCoeff(), back = points.col(2).minCoeff();
        const double half_breadth = 0.25 * (points.col(0).maxCoeff() - points.col(0).minCoeff());
        const double middle = 0.5 * (points.col(0).maxCoeff() + points.col(0).minCoeff());
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        int count = 0;
        for (Eigen::Index v = 0; v < points.rows(); ++v) {
            if (points(v, 2) < front - front_share * (front - back)) continue;
            if (std::abs(points(v, 0) - middle) > half_breadth) continue;
            sum += points.row(v);
            ++count;
        }
        centres.row(i) = count > 0 ? Eigen::RowVector3d(sum / count) : Eigen::RowVector3d(points.colwise().mean());
    }
    Points levels(num_spine_levels, 3);
    for (int i = 1; i < num_vertebrae; ++i) levels.row(i) = 0.5 * (centres.row(i - 1) + centres.row(i));
    levels.row(0) = centres.row(0) + (centres.row(0) - levels.row(1));
    levels.row(num_vertebrae) = head_joint.transpose();
    return levels;
}

}  // namespace ndg
