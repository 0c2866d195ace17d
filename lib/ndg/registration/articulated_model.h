// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/scan/skin_places.h"

#include <string>
#include <vector>

namespace ndg {

/// The template's skin with a pose and proportions, the same left and right: every part of the trunk is scaled in
/// breadth, height and depth, every limb along its bone and across it, at either end by another factor, head, hands and
/// feet as wholes; and the joints turn. Fingers, toes, jaw and eyes go with hand, foot and head.
///
/// Parameters, `num_parameters()` of them, all zero for the template as it stands: root rotation vector (world) and
/// translation (m), logarithm of the overall scale, rotation vectors of the joints, logarithms of the parts' scales.
class ArticulatedModel {
public:
    explicit ArticulatedModel(SkinnedSurface skin);

    int num_parameters() const { return static_cast<int>(prior_.rows()); }
    int num_vertices() const { return static_cast<int>(skin_.vertices.rows()); }
    const SkinnedSurface& skin() const { return skin_; }

    /// Rest shape of the scaled template (skin vertices `rows`, or all if empty) and its joints.
    Points rest_vertices(const Eigen::VectorXd& parameters, const std::vector<int>& rows = {}) const;
    Points rest_joints(const Eigen::VectorXd& parameters) const;
    Pose pose(const Eigen::VectorXd& parameters) const;
    /// The posed skin (vertices `rows`, or all if empty).
    Points posed_vertices(const Eigen::VectorXd& parameters, const std::vector<int>& rows = {}) const;

    /// Derivative of posed_vertices by every parameter but those of inactive ones, by central differences:
    /// 3 |rows| x parameters, row-major points.
    Eigen::MatrixXd jacobian(const Eigen::VectorXd& parameters, const std::vector<int>& rows) const;

    /// Rows of the prior: |prior * parameters|^2 is 1 where a joint is turned, or a part scaled, by one standard
    /// deviation. P x P; zero rows for root and overall scale.
    const Eigen::MatrixXd& prior() const { return prior_; }

    /// First parameter of the joints' rotations and of the parts' scales.
    int rotation_begin() const { return 7; }
    int scale_begin() const { return scale_begin_; }

    /// All parameters zero but for arms along these directions (left; right is its mirror image), a share of the turn
    /// taken by the clavicles.
    Eigen::VectorXd with_arms(const Eigen::Vector3d& left_direction) const;

private:
    struct Turn {
        std::vector<int> joints;  ///< turn by equal shares
        int parameter;
    };
    enum class PartKind {
        trunk,  ///< scales along x, y, z
        limb,   ///< scales along the bone, across it where it begins, and where it ends
        whole   ///< one scale
    };
    struct Part {
        PartKind kind;
        int parameter;
        int num_parameters() const { return kind == PartKind::whole ? 1 : 3; }
    };
    /// The part that goes with a joint.
    struct JointPart {
        int part = -1;
        Eigen::Vector3d origin = Eigen::Vector3d::Zero();      ///< where the bone begins
        Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< of the bone
        double length = 1.0;
    };
    class Scale;
    /// First parameter of the turn of a joint that turns alone.
    int turn_parameter(const std::string& joint) const;
    void add_turn(const std::vector<std::string>& joints, double degrees_across, double degrees_along,
                  const Eigen::Vector3d& axis, std::vector<Eigen::Matrix3d>& priors);
    std::vector<Scale> joint_scales(const Eigen::VectorXd& parameters) const;

    SkinnedSurface skin_;
    std::vector<Turn> turns_;
    std::vector<Part> parts_;
    std::vector<JointPart> joint_parts_;
    int scale_begin_ = 0;
    Eigen::MatrixXd prior_;
};

}  // namespace ndg
