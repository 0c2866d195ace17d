// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/bone_carrying.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace ndg {
namespace {

constexpr double min_breadth = 0.6;        ///< least scale across a bone against that along it
constexpr double breadth_quantile = 0.12;  ///< of a joint's vertices that may ask for less
constexpr double bone_depth = 0.0045;      ///< m under the skin that breadths leave
/// Growth of a bone's breadth with the body mass index, per kg/m^2 from 23.5: joints of heavier people are broader by
/// caliper (Heinz et al. 2003), of which skin has its part.
constexpr double breadth_growth = 0.001, usual_bmi = 23.5;
constexpr double max_breadth = 1.2;
constexpr int min_breadth_vertices = 8;  ///< of a joint, to judge by
constexpr double press_length = 0.05;    ///< m, over which it fades that the bone wrap is pressed under the skin
constexpr double press_tie = 10.0;       ///< weight of the depth wanted there
constexpr int press_rounds = 4;

/// Similarity transform for each joint that takes the bones around it (the joint, its parent and its children) from the
/// template's places to the body's. What these few points leave open, as the turn about a straight limb, stays as it
/// is.
std::vector<Eigen::Affine3d> bone_similarities(const Template& body_template,
                                               const Eigen::Ref<const Points>& joint_positions, double scale)
{
    constexpr double prior = 0.05;  ///< weight of not turning
    const Points& from = body_template.rest.joint_positions;
    const int num_joints = body_template.skeleton.num_joints();
    std::vector<Eigen::Affine3d> result(num_joints, Eigen::Affine3d::Identity());
    for (int j = 0; j < num_joints; ++j) {
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        double spread = 0.0, stretched = 0.0;
        for (int other = 0; other < num_joints; ++other) {
            const bool parent = body_template.skeleton.parents[j] == other;
            if (body_template.skeleton.parents[other] != j && !parent) continue;
            const double weight = parent ? 0.3 : 1.0;
            const Eigen::Vector3d a = (from.row(other) - from.row(j)).transpose();
            const Eigen::Vector3d b = (joint_positions.row(other) - joint_positions.row(j)).transpose();
            covariance += weight * b * a.transpose();
            spread += weight * a.squaredNorm();
            stretched += weight * b.squaredNorm();
        }
        covariance += prior * spread * Eigen::Matrix3d::Identity();
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Vector3d sign = Eigen::Vector3d::Ones();
        if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
        const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
        const double size = spread > 0.0 ? std::sqrt(stretched / spread) : scale;
        Eigen::Affine3d& transform = result[j];
        transform.linear() = size * rotation;
        transform.translation() = joint_positions.row(j).transpose() - transform.linear() * from.row(j).transpose();
    }
    return result;
}

/// Direction of each joint's bone in a body: to its children's mean, from its parent where it has none.
Points bone_axes(const Skeleton& skeleton, const Eigen::Ref<const Points>& joint_positions)
{
    const int num_joints = skeleton.num_joints();
    Points axes = Points::Zero(num_joints, 3);
    for (int j = 0; j < num_joints; ++j) {
        const int parent = skeleton.parents[j];
        if (parent >= 0) axes.row(parent) += joint_positions.row(j) - joint_positions.row(parent);
    }
    for (int j = 0; j < num_joints; ++j) {
        const int parent = skeleton.parents[j];
        if (axes.row(j).norm() < 1e-9 && parent >= 0)
            axes.row(j) = joint_positions.row(j) - joint_positions.row(parent);
        if (axes.row(j).norm() > 0.0) axes.row(j).normalize();
    }
    return axes;
}

/// What hangs on a joint of the trunk or on a clavicle, carried: by the trunk's map, and from the sternal end of the
/// clavicle to the shoulder more and more with the shoulder's joint.
class TrunkCarrier {
public:
    TrunkCarrier(const Template& body_template, const Eigen::Ref<const Points>& joint_positions, const TrunkMap& trunk)
        : trunk_(trunk), kinds_(body_template.skeleton.num_joints(), Kind::limb)
    {
        const Skeleton& skeleton = body_template.skeleton;
        const Points& from = body_template.rest.joint_positions;
        for (int j = 0; j < skeleton.num_joints(); ++j) {
            const std::string& name = skeleton.joint_names[j];
            const bool axial = name == "pelvis" || name.rfind("spine_", 0) == 0 || name.rfind("neck_", 0) == 0;
            if (axial) kinds_[j] = Kind::trunk;
            if (name == "left_clavicle" || name == "right_clavicle") kinds_[j] = Kind::shoulder;
        }
        for (int side = 0; side < 2; ++side) {
            const int shoulder = skeleton.joint(side == 0 ? "left_upper_arm" : "right_upper_arm");
            const int clavicle = skeleton.joint(side == 0 ? "left_clavicle" : "right_clavicle");
            shoulder_moves_[side] = joint_positions.row(shoulder).transpose() - trunk_(from.row(shoulder).transpose());
            begin_ = std::abs(from(clavicle, 0));
            end_ = std::abs(from(shoulder, 0));
        }
    }

    bool carries(Eigen::Index joint) const { return kinds_[joint] != Kind::limb; }
    Eigen::Vector3d operator()(Eigen::Index joint, const Eigen::Vector3d& point) const
    {
        const Eigen::Vector3d carried = trunk_(point);
        if (kinds_[joint] == Kind::trunk) return carried;
        const double t = std::clamp((std::abs(point[0]) - begin_) / (end_ - begin_), 0.0, 1.0);
        return carried + t * t * (3.0 - 2.0 * t) * shoulder_moves_[point[0] > 0.0 ? 0 : 1];
    }

private:
    enum class Kind { limb, trunk, shoulder };
    const TrunkMap& trunk_;
    std::vector<Kind> kinds_;
    std::array<Eigen::Vector3d, 2> shoulder_moves_;  ///< left, right
    double begin_ = 0.0, end_ = 1.0;                 ///< m from the midline in the template
};

Points blended(const std::vector<Eigen::Affine3d>& transforms, const TrunkCarrier& trunk,
               const Eigen::Ref<const RowMatrix>& weights, const Eigen::Ref<const Points>& points)
{
    Points carried = Points::Zero(points.rows(), 3);
    for (Eigen::Index w = 0; w < carried.rows(); ++w)
        for (Eigen::Index j = 0; j < weights.cols(); ++j) {
            if (weights(w, j) <= 0.0) continue;
            const Eigen::Vector3d point = points.row(w).transpose();
            carried.row(w) += weights(w, j) * (trunk.carries(j) ? trunk(j, point) : transforms[j] * point).transpose();
        }
    return carried;
}

/// Whether a joint moves a long bone.
bool is_long_bone(const std::string& joint)
{
    for (const char* name : {"_upper_arm", "_forearm", "_forearm_twist", "_thigh", "_shin"})
        if (joint.size() > std::strlen(name) &&
            joint.compare(joint.size() - std::strlen(name), std::string::npos, name) == 0)
            return true;
    return false;
}

/// Scale of each joint's bone across its axis against that along it: `wanted`, or what keeps it under the skin.
Eigen::VectorXd breadths(const Skeleton& skeleton, const Eigen::Ref<const RowMatrix>& weights,
                         const Eigen::Ref<const Points>& bone_wrap, const Eigen::Ref<const Points>& skin_wrap,
                         const Eigen::Ref<const Points>& joint_positions, const Points& axes,
                         const Eigen::Ref<const Eigen::VectorXd>& wanted)
{
    const int num_joints = skeleton.num_joints();
    std::vector<std::vector<double>> ratios(num_joints);
    for (Eigen::Index w = 0; w < bone_wrap.rows(); ++w) {
        Eigen::Index j = 0;
        if (weights.row(w).maxCoeff(&j) <= 0.5) continue;
        const auto across = [&](const Eigen::Ref<const Points>& points) {
            const Eigen::RowVector3d arm = points.row(w) - joint_positions.row(j);
            return (arm - arm.dot(axes.row(j)) * axes.row(j)).norm();
        };
        const double bone = across(bone_wrap);
        if (bone > 1e-6) ratios[j].push_back((across(skin_wrap) - bone_depth) / bone);
    }
    Eigen::VectorXd result = wanted;
    for (int j = 0; j < num_joints; ++j) {
        // Both sides together, so that a body's two halves stay alike.
        std::string other = skeleton.joint_names[j];
        std::vector<double> own = ratios[j];
        if (other.rfind("left_", 0) == 0 || other.rfind("right_", 0) == 0) {
            other = other[0] == 'l' ? "right_" + other.substr(5) : "left_" + other.substr(6);
            const auto& mirrored = ratios[skeleton.joint(other)];
            own.insert(own.end(), mirrored.begin(), mirrored.end());
        }
        if (own.size() < static_cast<std::size_t>(min_breadth_vertices)) continue;
        const auto at = own.begin() + static_cast<std::ptrdiff_t>(breadth_quantile * static_cast<double>(own.size()));
        std::nth_element(own.begin(), at, own.end());
        result[j] = std::clamp(std::min(*at, wanted[j]), min_breadth, max_breadth);
    }
    return result;
}

}  // namespace

Points carried_bone_wrap(const Template& body_template, const Eigen::Ref<const RowMatrix>& weights,
                         const Eigen::Ref<const Points>& skin_wrap, const Eigen::Ref<const Points>& joint_positions,
                         double scale, double bmi, const TrunkMap& trunk_map)
{
    const Points bone_wrap = body_template.rest.volume_vertices.topRows(body_template.num_wrap_vertices());
    std::vector<Eigen::Affine3d> transforms = bone_similarities(body_template, joint_positions, scale);
    const TrunkCarrier trunk(body_template, joint_positions, trunk_map);
    const Points carried = blended(transforms, trunk, weights, bone_wrap);
    const Points axes = bone_axes(body_template.skeleton, joint_positions);
    Eigen::VectorXd wanted = Eigen::VectorXd::Ones(body_template.skeleton.num_joints());
    for (int j = 0; j < body_template.skeleton.num_joints(); ++j) {
        if (!is_long_bone(body_template.skeleton.joint_names[j])) continue;
        const double along = std::cbrt(transforms[j].linear().determinant());
        wanted[j] = std::sqrt(scale / along) * (1.0 + breadth_growth * (bmi - usual_bmi));
    }
    const Eigen::VectorXd breadth =
        breadths(body_template.skeleton, weights, carried, skin_wrap, joint_positions, axes, wanted);
    for (int j = 0; j < body_template.skeleton.num_joints(); ++j) {
        const Eigen::Vector3d axis = axes.row(j).transpose(), joint = joint_positions.row(j).transpose();
        const Eigen::Matrix3d shrink =
            breadth[j] * Eigen::Matrix3d::Identity() + (1.0 - breadth[j]) * axis * axis.transpose();
        transforms[j] = Eigen::Translation3d(joint) * shrink * Eigen::Translation3d(-joint) * transforms[j];
    }
    return blended(transforms, trunk, weights, bone_wrap);
}

void press_under_skin(const Eigen::Ref<const Points>& skin_wrap, const Eigen::Ref<const Triangles>& triangles,
                      double depth, Points& bone_wrap)
{
    const auto count = static_cast<int>(skin_wrap.rows());
    const auto neighbours = vertex_neighbours(triangles, count);
    const Points normals = vertex_normals(skin_wrap, triangles);
    const Eigen::VectorXd wanted = depth - (skin_wrap - bone_wrap).cwiseProduct(normals).rowwise().sum().array();
    std::vector<Eigen::Triplet<double>> entries;
    double edges = 0.0, length = 0.0;
    for (int v = 0; v < count; ++v) {
        const auto& ring = neighbours[v];
        entries.emplace_back(v, v, -1.0);
        for (const int n : ring) {
            entries.emplace_back(v, n, 1.0 / static_cast<double>(ring.size()));
            length += (skin_wrap.row(v) - skin_wrap.row(n)).norm();
        }
        edges += static_cast<double>(ring.size());
    }
    Eigen::SparseMatrix<double> laplacian(count, count);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SparseMatrix<double> bending = laplacian.transpose() * laplacian;
    const double zero_pull = std::pow(length / edges / press_length, 4);
    Eigen::VectorXd press = Eigen::VectorXd::Zero(count), ties = Eigen::VectorXd::Zero(count);
    SparseCholesky solver;
    for (int round = 0; round < press_rounds; ++round) {
        const Eigen::Array<bool, Eigen::Dynamic, 1> missed = press.array() < wanted.array();
        if (!missed.any()) break;
        ties = missed.select(Eigen::VectorXd::Constant(count, press_tie), ties);
        Eigen::SparseMatrix<double> matrix = bending;
        for (int v = 0; v < count; ++v) matrix.coeffRef(v, v) += zero_pull + ties[v];
        if (round == 0) solver.analyze(matrix);
        require(solver.factorize(matrix), "the depth of the bone wrap could not be smoothed");
        press = solver.solve(ties.cwiseProduct(wanted));
    }
    press = press.cwiseMax(wanted).cwiseMax(0.0);
    bone_wrap -= press.asDiagonal() * normals;
}

}  // namespace ndg
