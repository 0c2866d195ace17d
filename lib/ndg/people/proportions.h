// SPDX-License-Identifier: Apache-2.0
// Lengths of limbs and breadth of shoulders over stature, as people have them.
#pragma once

#include "ndg/makehuman/makehuman.h"

#include <array>

namespace ndg {

/// What a proportion is measured between, whose mean and spread are published, and MakeHuman's detail that changes it.
struct Proportion {
    const char* detail;
    double slope;                                 ///< change of the proportion by one unit of the detail, roughly
    double female, male, deviation;               ///< mean and standard deviation, over stature
    double (*measure)(const ParametricSurface&);  ///< m
};

/// Between the rig's joints, after ANSUR II (Gordon et al. 2014, NATICK/TR-15/007; 1986 women, 4082 men):
///   shoulders   biacromial breadth 0.224 and 0.237 +- 0.010, less 10 mm of skin
///   upper arm   acromion to radiale 0.191 +- 0.007, less what lies above shoulder and below elbow joint (0.026)
///   forearm     radiale to stylion 0.148 and 0.153 +- 0.007, less 0.003
///   knee        height of the lateral epicondyle, 0.286 +- 0.010 and 0.280 +- 0.008
///   hip         height of the trochanterion, 0.519 +- 0.014 and 0.513 +- 0.015
constexpr int num_proportions = 5;
const std::array<Proportion, num_proportions>& proportions();

/// Wished values over stature.
using ProportionValues = std::array<double, num_proportions>;
/// The mean plus `deviations` standard deviations of each, `sex` 0 female to 1 male.
ProportionValues usual_proportions(double sex, const std::array<double, num_proportions>& deviations = {});

/// Who has high knees has high hips: makes the deviation of the hip follow that of the knee (correlation 0.8, as
/// between heights of the legs' landmarks).
void correlate_legs(std::array<double, num_proportions>& deviations);

/// One step of the details towards the wished proportions of the body that `parameters` give. Returns the largest miss
/// before it, over stature, leaving out details at their end.
double approach_proportions(const ParametricSurface& surface, const ProportionValues& wished,
                            MakeHumanParameters& parameters);

}  // namespace ndg
