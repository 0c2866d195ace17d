// SPDX-License-Identifier: Apache-2.0
// Protrusion of this project's bodies: embedded bones and muscles against the skin of the volumetric region.
#pragma once

#include "ndg/dataset/deformation_file.h"
#include "ndg/deform/posed_body.h"
#include "ndg/protrusion/frame_protrusion.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace ndg {

/// What of a template's anatomy and skin is compared: triangles whose vertices are all embedded, none beyond the cuts
/// at head, hands and toes; the volumetric region of the skin.
class BodyProtrusion {
public:
    /// Keeps a reference. Throws InputError for a template without anatomy.
    explicit BodyProtrusion(const Template& body_template);

    /// `anatomy_rest`: anatomy_at_rest of the body; `deformed_volume`: N_v x 3.
    FrameProtrusion posed(const PosedBody& posed, const Eigen::Ref<const Points>& anatomy_rest,
                          const Eigen::Ref<const Points>& deformed_volume) const;
    FrameProtrusion at_rest(const Body& body) const;
    /// Name of the bone or muscle that the deepest vertex belongs to; empty for none.
    std::string deepest_part(const FrameProtrusion& frame) const;
    /// Names of the bones and muscles that cross the skin.
    std::set<std::string> intersecting_parts(const FrameProtrusion& frame) const;

private:
    std::string part_of(int vertex) const;
    FrameProtrusion measure(Points skin_vertices, const Points& anatomy) const;

    const Template* template_;
    std::vector<char> compared_skin_;
    Triangles compared_anatomy_;
};

/// Table 3 over pairs of bodies and poses.
struct ProtrusionTable {
    std::vector<ProtrusionRow> rows;  ///< of the files, in their order
    int pairs = 0;                    ///< looked at
    int colliding_pairs = 0;          ///< of these, left out because coarse parts of the body collide
    /// Of the bodies that were measured, those whose anatomy crosses the skin, or sticks out, at rest already.
    int bodies = 0, bodies_intersecting_at_rest = 0, bodies_protruding_at_rest = 0;
    std::map<std::string, int> parts_intersecting_at_rest;  ///< bone or muscle -> bodies
};

/// A deformation file and the path it was read from, for messages.
struct ProtrusionInput {
    std::string path;
    DeformationSet set;
};

/// Measures every file on those of `pairs` in which coarse parts of the skinned body do not collide (CoarseParts). All
/// files are of bodies posed alike. Throws InputError where a file lacks a pair or is posed otherwise, or where no pair
/// is left.
ProtrusionTable body_protrusion(const Template& body_template, const BodySet& bodies, const std::vector<Pose>& poses,
                                const std::vector<SamplePair>& pairs, const std::vector<ProtrusionInput>& files);

}  // namespace ndg
