// SPDX-License-Identifier: Apache-2.0
// The volume of a body in motion with what is measured of it, for ParaView.
#pragma once

#include "ndg/body/template.h"
#include "ndg/export/volume_sequence.h"

#include <functional>
#include <optional>

namespace ndg {

/// A body in one frame.
struct BodyVolume {
    const Body* body = nullptr;         ///< at rest
    Points volume_vertices;             ///< N_v x 3
    Points interior_vertices;           ///< N_i x 3
    std::optional<StoredArray> stored;  ///< where volume_vertices stand, in all frames or in none
    Points reference;                   ///< N_v x 3 of another method; no rows: none, in all frames or in none
};

/// Stiffness of the layers, Pa; what simulation takes where nothing else is said (NDG 3.2).
struct LayerStiffness {
    double young_muscle = 45e3, young_fat = 15e3;
};

/// Grids "flesh" (prisms) and "bone_interior" (tetrahedra). Fields of both: volume_change (V / V_rest - 1), determinant
/// (of the flesh det F_p, of NDG equation 3; of tetrahedra V / V_rest; 0 where a tetrahedron has no volume at rest),
/// layer (0 inside the bone wrap, 1 muscle, 2 fat) and young_modulus (0 inside the bone wrap, which nothing deforms);
/// of the flesh also error, distance to the reference in m, where there is one. `template_path`: the template's file.
VolumeSequence body_volume(const Template& body_template, const std::string& template_path,
                           const LayerStiffness& stiffness, std::function<BodyVolume(int frame_idx)> frame);

}  // namespace ndg
