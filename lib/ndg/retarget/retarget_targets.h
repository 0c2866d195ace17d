// SPDX-License-Identifier: Apache-2.0
// Where joints of ours should be: the source's joints, limb by limb in our proportions.
#pragma once

#include "ndg/retarget/retarget_transfer.h"

#include <vector>

namespace ndg {

/// Landmarks are joints of ours that have a joint of the source to lie on: its entry in the map has one source and no
/// blend, and every joint above it turns with source joints above that one alone (so not the single chest joint of a
/// coarse skeleton, which lies at the waist while ours is spread over the spine).
///
/// Each landmark hangs on the nearest landmark above it, or on the root joint. With x the source's joint positions in a
/// frame, x0 at its zero pose, z ours with the rest poses aligned (RotationTransfer), the target of landmark c on p is
///   t_c = t_p + k R D R^T (x_c - x_p),   k = |z_c - z_p| / |x0_c - x0_p|,
/// D the minimal rotation from x0_c - x0_p to z_c - z_p, R the source's rotation of p: the source's own segment, in our
/// length, from which the difference of the rest poses is taken off in the frame of p. D is the identity for limbs.
/// Where further joints of ours that the source moves lie between (the spine), the landmarks on the same joint q form a
/// cluster: its centroid takes the place of c, with R half way from p's rotation to q's, and the members lie about the
/// centroid likewise with q's rotation; the midpoint of the hips stands for p if that is the root joint. A segment
/// without length in the source (lost by some converters) is ours, turned as the source turns p or q.
class ScaledTargets {
public:
    ScaledTargets(const RotationTransfer& transfer, const Eigen::Ref<const Points>& joint_positions);

    const std::vector<int>& landmarks() const { return landmarks_; }  ///< joints of ours, ascending
    /// Targets against the root joint, L x 3, metres.
    Points targets(int frame_idx) const;
    /// The source's positions scaled as a whole (leg length), L x 3, the midpoints of the hips in the same place.
    /// `pelvis`: world rotation of our root joint.
    Points uniform_targets(int frame_idx, const Eigen::Matrix3d& pelvis) const;

private:
    /// Scaling and redirection of one vector of the source.
    struct Segment {
        bool has_length = false;
        double factor = 1.0;
        Eigen::Matrix3d redirection = Eigen::Matrix3d::Identity();
        Eigen::Vector3d ours = Eigen::Vector3d::Zero();  ///< aligned rest pose

        Eigen::Vector3d apply(const Eigen::Matrix3d& turned, const Eigen::Vector3d& source) const;
    };
    struct Member {
        int landmark_idx = 0;
        Segment from_centre;
    };
    struct Cluster {
        int base_landmark_idx = -1;  ///< -1: the root joint
        int base = 0, carrier = 0;   ///< joints p and q
        Segment to_centre;
        std::vector<Member> members;

        /// The trunk is measured from the hips: where a rig has its root joint in the pelvis is its own affair.
        bool from_hips() const { return base == 0 && carrier != 0; }
    };

    Segment segment(const Eigen::Vector3d& source, const Eigen::Vector3d& ours) const;
    Eigen::Vector3d source_base(const Cluster& cluster, const Points& source_positions) const;
    Eigen::Vector3d our_base(const Cluster& cluster, const Points& aligned) const;
    Eigen::Vector3d source_centre(const Cluster& cluster, const Points& source_positions) const;

    const RotationTransfer& transfer_;
    std::vector<int> landmarks_;
    std::vector<Cluster> clusters_;
};

}  // namespace ndg
