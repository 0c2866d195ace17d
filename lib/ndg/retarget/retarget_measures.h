// SPDX-License-Identifier: Apache-2.0
// Comparisons of a retargeted frame with its source.
#pragma once

#include "ndg/retarget/retarget_report.h"
#include "ndg/retarget/retarget_transfer.h"

#include <array>
#include <string>
#include <vector>

namespace ndg {

/// Angle (rad) by which the rotation of the source's joint b against its joint a (-1: the world) changes from frame
/// `frame_idx` - 1 to `frame_idx`.
double relative_jump(const MotionClip& clip, int frame_idx, int a, int b);

/// Angle (rad) between the bones that the map aligns, from joint to joint, in the source and in ours; mean over the
/// bones. `rest`: J x 3 joint positions, `parent_from_joint`: J local rotations.
double direction_error(const RotationTransfer& transfer, const Points& rest,
                       const std::vector<Eigen::Matrix3d>& parent_from_joint, int frame_idx);

/// Angles between the directions of limb segments, trunk, hips and shoulders of the source and ours in the world.
class SegmentDirections {
public:
    explicit SegmentDirections(const RotationTransfer& transfer);
    /// `rest`: J x 3 joint positions, `parent_from_joint`: J local rotations.
    void add(const Points& rest, const std::vector<Eigen::Matrix3d>& parent_from_joint, int frame_idx);
    /// Of the segments whose joints the source has, over the frames added; empty where there are none.
    std::vector<SegmentError> errors() const;

private:
    /// From the middle of two joints of ours to that of two others; once the same for a joint alone.
    struct Segment {
        std::string name;
        std::array<int, 2> from, to;
        double sum = 0.0, max = 0.0;
    };
    const RotationTransfer& transfer_;
    std::vector<Segment> segments_;
    int num_frames_ = 0;
};

}  // namespace ndg
