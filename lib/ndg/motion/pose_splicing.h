// SPDX-License-Identifier: Apache-2.0
// New poses from parts of captured ones.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace ndg {

/// Trunk, head and limbs of a body as capsules: segments with the radius of the skin about them, to tell poses in which
/// limbs pass through each other or the trunk.
class LimbCapsules {
public:
    /// Of the template body. Throws Error where a part has no skin of its own.
    explicit LimbCapsules(const Template& body_template);

    /// Greatest depth, m, by which a forearm or hand enters trunk, head or legs, or a thigh or shank trunk or head; 0
    /// where none does. The half of a thigh at the hip is left out.
    double overlap(const Pose& pose) const;

private:
    struct End {
        int joint;             ///< that moves it
        Eigen::Vector3d rest;  ///< m
    };
    struct Capsule {
        End begin, end;
        double radius = 0.0;  ///< m
    };

    Skeleton skeleton_;
    Points joint_positions_;
    std::vector<Capsule> capsules_;
    std::vector<std::pair<int, int>> pairs_;  ///< of capsules that may overlap
};

struct SplicedPoses {
    std::vector<Pose> poses;
    std::vector<std::array<int, 3>> sources;  ///< of each: poses of trunk and head, of the arms, of the legs
};

/// `count` poses with trunk, neck and head of one pose, both arms of a second and both legs of a third, drawn with
/// `seed`. Every joint keeps its rotation against its parent, so none leaves the range it was in. Where limbs overlap
/// deeper than `allowed_overlap` (m) and than in all three sources, another three are drawn. Root motion is that of the
/// trunk's pose. The result does not depend on the number of threads. Throws InputError for fewer than two poses, or
/// when a hundred draws in a row do not suffice.
SplicedPoses splice_poses(const std::vector<Pose>& poses, const Template& body_template, int count, std::uint64_t seed,
                          double allowed_overlap = 0.01);

/// Appends `count` spliced poses of `poses` to `kept`, a subset of it: of four times as many drawn those that
/// farthest-point sampling finds, going on from `kept`; distances by the joints marked. They are frames of a clip
/// "spliced".
void append_spliced(PoseSet& kept, const PoseSet& poses, const Template& body_template, const std::vector<int>& marked,
                    int count, std::uint64_t seed);

}  // namespace ndg
