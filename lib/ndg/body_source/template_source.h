// SPDX-License-Identifier: Apache-2.0
// What a template is made from: a skin with skeleton and weights, and the anatomy inside it.
#pragma once

#include "ndg/body/anatomy_part.h"
#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/types.h"
#include "ndg/geometry/triangle_mesh.h"

#include <string>
#include <vector>

namespace ndg {

/// One bone or muscle in the rest pose of the source's skin: a closed surface without holes, outward, in metres.
struct AnatomyMesh : TriangleMesh {
    std::string name;  ///< as the source names it, e.g. "Left femur"
    int fma_id = 0;    ///< Foundational Model of Anatomy; 0 for none
    BodySide side = BodySide::middle;
    AnatomyLayer layer = AnatomyLayer::bone;
    /// Joint whose motion the part follows where it lies outside the volumetric region (skull, hands, toes); empty:
    /// it follows the skin next to it.
    std::string joint;
};

/// MakeHuman's skin with BodyParts3D's anatomy, or the procedural body; stored with a template as its source_name.
enum class SourceKind { anatomy, procedural };
template <>
inline constexpr EnumName<SourceKind> enum_table<SourceKind>[] = {{SourceKind::anatomy, "anatomy"},
                                                                  {SourceKind::procedural, "procedural"}};

struct TemplateSource {
    SourceKind kind = SourceKind::procedural;
    std::string licence;  ///< credit lines stored in everything made from it
    ParametricSurface surface;
    RowMatrix weights;  ///< N x J, dense, rows sum to one
    Points
        joint_positions;  ///< J x 3, centres of rotation by the bones; surface.joint_positions is the source's own rig
    std::vector<AnatomyMesh> anatomy;
};

}  // namespace ndg
