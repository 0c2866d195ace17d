// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/error.h"
#include "ndg/motion/clinical_angles.h"

#include <string>
#include <utility>
#include <vector>

namespace ndg::bench {

/// Poses of clinical angles in degrees; "both_" stands for left_ and right_.
inline Pose clinical_pose(const ClinicalFrames& frames, const std::vector<std::pair<std::string, double>>& degrees)
{
    std::vector<double> angles(clinical_angle_names().size(), 0.0);
    for (const auto& [name, value] : degrees) {
        const bool both = name.rfind("both_", 0) == 0;
        for (const std::string side : {"left_", "right_"}) {
            const int angle = find_clinical_angle(both ? side + name.substr(5) : name);
            require(angle >= 0, "there is no angle {}", name);
            angles[angle] = value * M_PI / 180.0;
        }
    }
    return frames.pose(angles);
}

struct NamedPose {
    std::string name;
    Pose pose;
};

/// Those in which joints bend furthest.
inline std::vector<NamedPose> named_poses(const ClinicalFrames& frames)
{
    const auto pose = [&](const std::vector<std::pair<std::string, double>>& degrees) {
        return clinical_pose(frames, degrees);
    };
    return {{"deep-squat", pose({{"both_knee.flexion", 140},
                                 {"both_hip.flexion", 115},
                                 {"both_ankle.dorsiflexion", 15},
                                 {"both_shoulder.elevation", 90},
                                 {"both_shoulder.plane", 90},
                                 {"trunk.flexion", 35}})},
            {"arms-overhead", pose({{"both_shoulder.elevation", 165}, {"both_clavicle.elevation", 20}})},
            {"arms-forward",
             pose({{"both_shoulder.elevation", 90}, {"both_shoulder.plane", 90}, {"both_clavicle.protraction", 15}})},
            {"bent-trunk", pose({{"trunk.flexion", 80}, {"trunk.turn_left", 20}, {"both_hip.flexion", 30}})},
            {"high-knee", pose({{"left_hip.flexion", 120}, {"left_knee.flexion", 130}})},
            {"deep-knee-bend", pose({{"both_knee.flexion", 145}})},
            {"pronated", pose({{"both_elbow.flexion", 90}, {"both_forearm.pronation", 70}})}};
}

/// Knees alone and squats, bent deeply.
inline std::vector<NamedPose> deep_knee_bends(const ClinicalFrames& frames)
{
    std::vector<NamedPose> poses;
    for (const double angle : {110.0, 120.0, 130.0, 145.0}) {
        poses.push_back({fmt::format("knees at {}", angle), clinical_pose(frames, {{"both_knee.flexion", angle}})});
        poses.push_back({fmt::format("squat at {}", angle),
                         clinical_pose(frames, {{"both_knee.flexion", angle}, {"both_hip.flexion", 110}})});
    }
    return poses;
}

}  // namespace ndg::bench
