// SPDX-License-Identifier: Apache-2.0
// Surfaces that can touch, and where they pass through each other.
#pragma once

#include "ndg/core/options.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

enum class SurfaceKind { obstacle, skin, cloth };

struct ContactSurface {
    std::string name;  ///< in messages
    SurfaceKind kind = SurfaceKind::skin;
    Triangles triangles;  ///< among all vertices of a scene
    bool meets_itself = false;
    double friction = -1;  ///< coefficient with every other surface; negative: by kinds
};

struct ContactSceneOptions {
    bool contact = false;  ///< also where a scene has nothing but the body
    double contact_distance = 2e-3;
    double contact_stiffness_pascal = 2e4;
    double friction_skin_obstacle = 0.5;
    double friction_skin_skin = 0.5;
    double friction_skin_cloth = 0.4;
    double friction_cloth_obstacle = 0.3;
    double friction_cloth_cloth = 0.3;
    double friction_obstacle_obstacle = 0.5;
    /// Least speed that counts as sliding, m/s; what sticks creeps slower than that.
    double slip_speed = 1e-3;
    /// Solves of a step; every one after the first takes the normal forces of the one before.
    int friction_solves = 1;
};
void describe(OptionList& list, ContactSceneOptions& options);

/// Coulomb's, of two surfaces: the mean of those they have themselves, the one that only one has, or by kinds.
double friction_coefficient(const ContactSurface& a, const ContactSurface& b, const ContactSceneOptions& options);

/// Vertices of one surface inside another, which is not cloth, or triangles of both that cross.
struct Penetration {
    std::string inner, outer;
    int vertices = 0;        ///< 0: only triangles cross
    double depth_metre = 0;  ///< of the deepest vertex
};

/// Of two different surfaces each, without what given vertices do among themselves: the first `num_given`.
std::vector<Penetration> find_penetrations(const std::vector<ContactSurface>& surfaces, const Points& positions,
                                           int num_given);
/// Throws InputError for the deepest, naming both surfaces and the depth.
void check_apart(const std::vector<ContactSurface>& surfaces, const Points& positions, int num_given);

}  // namespace ndg
