// SPDX-License-Identifier: Apache-2.0
// Bones by name, and places on a bone's surface.
#pragma once

#include "ndg/body/template.h"
#include "ndg/body_source/template_source.h"
#include "ndg/geometry/sphere.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

/// Finds parts by name, in any letter case. Keeps pointers to `parts`.
class PartFinder {
public:
    explicit PartFinder(const std::vector<AnatomyMesh>& parts);
    /// Throws Error naming a missing part.
    const AnatomyMesh& part(const std::string& name) const;
    /// nullptr for a missing part.
    const AnatomyMesh* find(const std::string& name) const;

private:
    std::map<std::string, const AnatomyMesh*> parts_;
};

/// The bones of a template as the vertices `anatomy` have them (N_a x 3, e.g. anatomy_at_rest of a body).
std::vector<AnatomyMesh> bone_meshes(const Template& body_template, const Eigen::Ref<const Points>& anatomy);

/// Mean of the vertices that lie within `depth` of the one farthest in `direction` (of any length).
Eigen::Vector3d end_centre(const Points& vertices, const Eigen::Vector3d& direction, double depth);
/// The vertex farthest in `direction`.
Eigen::Vector3d farthest(const Points& vertices, const Eigen::Vector3d& direction);
/// Mean of the vertices.
Eigen::Vector3d middle(const Points& vertices);
/// Vertices whose distance from `centre` is at most `radius`.
Points near(const Points& vertices, const Eigen::Vector3d& centre, double radius);
/// Head of femur or humerus: the sphere through what lies around the bone's end in `direction` (up and inwards).
/// `expected_radius`: m, within a third of the true one.
Sphere head_sphere(const Points& vertices, const Eigen::Vector3d& direction, double expected_radius);

}  // namespace ndg
