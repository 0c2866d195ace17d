// SPDX-License-Identifier: Apache-2.0
// Simplified muscles between the bones of the procedural body: spindles and sheets that follow the lean body's skin.
#pragma once

#include "ndg/body_source/template_source.h"
#include "ndg/procedural/field.h"
#include "ndg/procedural/layout.h"

#include <string>
#include <vector>

namespace ndg {

/// A station on a muscle's way from origin to insertion.
struct MuscleStation {
    Eigen::Vector3d place;
    double superficial;  ///< 1: lies right under the skin's fat, wherever `place` is beneath it; 0: lies at `place`
    double width;        ///< half width, m
    double thickness;    ///< half thickness, m
};

/// A muscle of the left side.
struct MuscleSketch {
    std::string name;  ///< without the side
    int fma_left = 0, fma_right = 0;
    std::vector<MuscleStation> stations;
};

/// Origins, insertions and ways after Gray's Anatomy (public domain edition of 1918); sizes by eye on the drawing
/// board, thicker by `layout.muscle()`.
std::vector<MuscleSketch> trunk_muscle_sketches(const BodyLayout& layout);
std::vector<MuscleSketch> limb_muscle_sketches(const BodyLayout& layout);

/// All muscles, left and right mirror images: closed, outward, layer "muscle". `lean_skin` is the skin without most of
/// its fat.
std::vector<AnatomyMesh> procedural_muscles(const BodyLayout& layout, const Field& lean_skin);

}  // namespace ndg
