// SPDX-License-Identifier: Apache-2.0
// Girths of a skin as a tape takes them.
#pragma once

#include "ndg/body/template.h"
#include "ndg/core/types.h"

namespace ndg {

/// Girths in metres; limbs are means of both sides.
struct BodyGirths {
    double neck = 0;       ///< smallest, across the neck's axis
    double abdomen = 0;    ///< horizontal, through the navel
    double waist = 0;      ///< smallest horizontal between navel and lower ribs
    double hip = 0;        ///< horizontal, where the buttocks stand out most
    double upper_arm = 0;  ///< across the middle between shoulder and elbow
    double forearm = 0;    ///< largest below the elbow
    double thigh = 0;      ///< across the middle between hip joint and knee
    double calf = 0;       ///< largest between knee and ankle
};

/// Girths of a skin in the template's tessellation (sites after Hodgdon and Beckett 1984 for the trunk, Lee et al. 2000
/// for the limbs; planes stand on the joints and on the template's landmarks navel, suprasternale and buttocks): the
/// perimeter of the convex hull of the section's part around the limb. Throws InputError naming a landmark the template
/// lacks, and naming `skin.name` where a plane does not meet the body.
BodyGirths measure_girths(const Template& body_template, const Skin& skin);

/// Perimeter of the convex hull of that closed part of the section with the plane through `centre` which surrounds
/// `centre`, m; of the nearest part where none does; 0 where the plane misses the surface. `normal` of any length.
double section_girth(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                     const Eigen::Vector3d& centre, const Eigen::Vector3d& normal);

}  // namespace ndg
