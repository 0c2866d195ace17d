// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"

#include <string>
#include <vector>

namespace ndg {

/// Volumes in m^3 and masses in kg of a part of the body.
struct SegmentMeasure {
    std::string name;
    double interior = 0, muscle = 0, fat = 0;  ///< volumes: inside the bone wrap, of the two layers
    double surface = 0;                        ///< volume of head, hands and toes, which have no layers
    double bones = 0;                          ///< volume of the bones inside the interior
    double mass = 0;
    double volume() const { return interior + muscle + fat + surface; }
};

/// Volume and mass of the body's segments, each element and part counted to the segment of the joint that moves it
/// most, and of the whole body (last). Densities: muscle 1060 kg/m^3 (Mendez and Keys 1960), fat 900 kg/m^3 (Fidanza,
/// Keys and Anderson 1953), whole bones with marrow 1300 kg/m^3 (ICRP Publication 89, 2002); what else the bone wrap
/// holds is soft tissue, in the trunk with lungs and other organs 970 kg/m^3 and head, hands and toes as a whole 1110,
/// 1160 and 1100 kg/m^3 (Dempster 1955: thorax 920, abdomen 1010, head 1110, hand 1160, foot 1100).
/// `anatomy`: N_a x 3, of that body (anatomy_at_rest).
std::vector<SegmentMeasure> segment_measures(const Template& body_template, const Body& body,
                                             const Eigen::Ref<const Points>& anatomy);

/// Largest relative difference between the volumes of a left and a right segment, and which.
double worst_asymmetry(const std::vector<SegmentMeasure>& segments, std::string& segment);

}  // namespace ndg
