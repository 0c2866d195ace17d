// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/dynamics/driven_body.h"

#include <string>
#include <vector>

namespace ndg {

/// Young's moduli of soft tissue along the skin's normal and along the skin, Pa: C values each, at the avatar's control
/// points, or one for all of the body.
struct TissueStiffness {
    std::vector<double> young_normal_pascal = {15e3}, young_tangent_pascal = {15e3};
};
/// Reads JSON {"young_normal_pascal": [...], "young_tangent_pascal": [...]} over what `stiffness` has; either may be
/// missing, be a list of as many numbers as there are control points, or one number. Throws InputError naming file,
/// item and value.
void read_stiffness(const std::string& path, const Avatar& avatar, TissueStiffness& stiffness);

/// An avatar's layer of soft tissue; fields between control points as the avatar interpolates them. Throws Error for
/// another number of values.
SoftBody soft_body_of(const Avatar& avatar, const TissueStiffness& stiffness);
/// Keeps a reference to the avatar.
SoftBodyPoser poser_of(const Avatar& avatar);

}  // namespace ndg
