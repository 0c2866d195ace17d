// SPDX-License-Identifier: Apache-2.0
// Bones of arm and knee that do not simply move with a joint of the skeleton. All positions are of a body at rest,
// motions take it to the posed world.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Height of points over the rib cage, an ellipsoid with axes along the world's and its centre in the plane of
/// symmetry.
class RibCage {
public:
    /// Least-squares fit to points of ribs, N x 3; the ellipsoid in their box where that is none.
    explicit RibCage(const Eigen::Ref<const Points>& ribs);
    /// Approximately in metres, exact to first order on the surface; negative inside.
    double height(const Eigen::Vector3d& point, Eigen::Vector3d* gradient = nullptr) const;

private:
    Eigen::Vector3d centre_ = Eigen::Vector3d::Zero(), half_axes_ = Eigen::Vector3d::Ones();
};

/// Clavicle and scapula of one side.
class ShoulderMotion {
public:
    /// `joint`: the glenohumeral centre, `elbow` and `sternoclavicular` as the skeleton has them. `clavicle`,
    /// `scapula`: vertices.
    ShoulderMotion(const Eigen::Vector3d& joint, const Eigen::Vector3d& elbow, const Eigen::Vector3d& sternoclavicular,
                   const Eigen::Ref<const Points>& clavicle, const Eigen::Ref<const Points>& scapula,
                   const RibCage& cage);

    struct Bones {
        Eigen::Isometry3d clavicle, scapula;
    };
    /// The scapula turns upwards with the arm's elevation against the thorax (scapulohumeral rhythm), counted from that
    /// at rest, about a point between the glenohumeral centre, which the pose carries with the clavicle, and the
    /// acromioclavicular joint; then its inner corners are brought back to the height over the ribs that they have at
    /// rest. The clavicle is the pose's, turned about its inner end to where the acromion is.
    Bones bones(const Eigen::Isometry3d& thorax, const Eigen::Isometry3d& clavicle,
                const Eigen::Isometry3d& upper_arm) const;

private:
    Eigen::Vector3d joint_, sternoclavicular_, acromioclavicular_, arm_, pivot_;
    Eigen::Vector3d plate_normal_, plate_side_;  ///< outwards from the ribs; towards the glenoid
    std::vector<Eigen::Vector3d> corners_;       ///< that glide: inferior and superior angle, root of the spine
    std::vector<double> corner_heights_;
    double rest_elevation_ = 0.0, up_sign_ = 1.0;
    const RibCage* cage_;
};

/// Upward turn of the scapula against the thorax for an elevation of the arm, both in radians.
double scapula_upward_turn(double arm_elevation);

/// Radius and ulna of one side.
class ForearmMotion {
public:
    ForearmMotion(const Eigen::Vector3d& elbow, const Eigen::Vector3d& wrist, const Eigen::Ref<const Points>& radius,
                  const Eigen::Ref<const Points>& ulna);

    struct Bones {
        Eigen::Isometry3d radius, ulna;
    };
    /// The radius turns with the hand's pronation about the axis from its head to the wrist; the ulna's lower end goes
    /// round that axis with it without turning, so it swings a little about the elbow.
    Bones bones(const Eigen::Isometry3d& forearm, const Eigen::Isometry3d& hand) const;

private:
    Eigen::Vector3d elbow_, wrist_, radial_head_, ulnar_head_;
};

}  // namespace ndg
