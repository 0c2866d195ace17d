// SPDX-License-Identifier: Apache-2.0
// The template: everything bodies share (tessellation, layers, skeleton, weights, anatomy and its embedding).
#pragma once

#include "ndg/body/anatomy_part.h"
#include "ndg/body/embedding.h"
#include "ndg/body/skeleton.h"
#include "ndg/body/skinning.h"
#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// A skin in the template's tessellation and its joints, at rest: all that is known of a person before layers are made.
struct Skin {
    std::string name;
    Points skin_vertices;    ///< N_s x 3, the whole closed skin with head, hands and toes
    Points joint_positions;  ///< J x 3
};

/// A body at rest: a skin with the layers below it.
struct Body : Skin {
    /// N_v x 3: bone wrap, muscle wrap and volumetric skin, N_w rows each (X-bar of the paper).
    Points volume_vertices;
    Points interior_vertices;  ///< N_i x 3, inside the bone wrap (TetGen's and the caps')
};

/// A named point of the skin.
struct Landmark {
    std::string name;
    int skin_triangle_idx = 0;
    Eigen::Vector3d barycentric = {1.0, 0.0, 0.0};
};

struct Template {
    Skeleton skeleton;
    Triangles skin_triangles;      ///< whole skin, indices into skin_vertices
    SkinningWeights skin_weights;  ///< N_s rows
    /// Names of the skin's regions, the volumetric one first; may be empty, then so is skin_regions.
    std::vector<std::string> skin_region_names;
    std::vector<int> skin_regions;     ///< T_s, indices into skin_region_names
    std::vector<Landmark> landmarks;   ///< on the skin
    std::vector<int> wrap_to_skin;     ///< N_w: skin vertex of each wrap vertex
    Triangles wrap_triangles;          ///< T_w x 3, indices into one wrap, 0..N_w-1 (the volumetric region)
    Prisms prisms;                     ///< N_p = 2 T_w rows into volume vertices: muscle layer first, then fat layer
    Tetrahedra tetrahedra;             ///< indices < N_w: bone wrap vertex; otherwise N_w + interior vertex
    SkinningWeights interior_weights;  ///< N_i rows
    Triangles anatomy_triangles;
    std::vector<AnatomyPart> anatomy_parts;
    /// Of the anatomy vertices; element -1 for those beyond the cuts, which are skinned with anatomy_weights.
    Embedding embedding;
    SkinningWeights anatomy_weights;  ///< N_a rows
    Points anatomy_vertices;          ///< N_a x 3, of the template body
    Body rest;                        ///< the template body itself

    /// Which parametric source the template was made from ("anatomy", "procedural"); empty for one that has none.
    std::string source_name;
    /// Where skin vertices come from, so that a parametric source can pose as this tessellation: barycentric points on
    /// the source's base mesh. Empty for a template that has none.
    RowMatrixI source_vertices;    ///< N_s x 3 base-mesh vertices
    RowMatrix source_barycentric;  ///< N_s x 3
    /// J x 3, from the source's own joints to those of the template body (which follow the bones), m.
    Points source_joint_offsets;
    /// People of the source, drawn once: what fits of scans know of the shapes of people. May be empty.
    std::vector<Skin> examples;

    /// SHA-256 of the file this template was read from; empty for one made in memory.
    std::string file_sha256;

    int num_wrap_vertices() const { return static_cast<int>(wrap_to_skin.size()); }
    int num_volume_vertices() const { return 3 * num_wrap_vertices(); }
    int num_prisms() const { return static_cast<int>(prisms.rows()); }
    /// First prism of the fat layer.
    int fat_begin() const { return num_prisms() / 2; }
    /// Weights of the volume vertices (each wrap carries those of its skin vertex), N_v rows.
    SkinningWeights volume_weights() const;
    /// 1 for joints that carry, or have a descendant that carries, at least a thousandth of some volume vertex; 0 for
    /// the others (fingers, jaw, eyes: simulation cannot see them) and for the root. J entries.
    std::vector<int> visible_joints() const;
    /// Weights of the prisms, of their corners together (for the rotations R_p of NDG 4.3), N_p rows.
    SkinningWeights prism_weights() const;
};

/// Muscle-layer prisms (muscle wrap outer, bone wrap inner), then fat-layer prisms (skin outer, muscle wrap inner).
Prisms layer_prisms(const Eigen::Ref<const Triangles>& wrap_triangles, int num_wrap_vertices);

void write_template(const std::string& path, const Template& body_template, const Provenance& provenance);
/// Throws InputError naming file, dataset and value for anything inconsistent.
Template read_template(const std::string& path);

/// People of one template as bodies or as skins only, and their parameters.
template <typename T>
struct PeopleOf {
    std::vector<T> bodies;
    std::vector<std::string> parameter_names;  ///< e.g. stature_m, mass_kg, bmi
    RowMatrix parameters;                      ///< bodies x parameters
    std::string template_sha256;               ///< Template::file_sha256 of the template these bodies belong to
};
using BodySet = PeopleOf<Body>;
using SkinSet = PeopleOf<Skin>;

void write_bodies(const std::string& path, const BodySet& bodies, const Provenance& provenance);
/// Checks every shape against the template, the template's hash (where both sides know it), and every rest prism for
/// positive Jacobians (InputError otherwise).
BodySet read_bodies(const std::string& path, const Template& body_template);

void write_skins(const std::string& path, const SkinSet& skins, const Provenance& provenance);
SkinSet read_skins(const std::string& path, const Template& body_template);

/// Smallest prism_min_jacobian over all prisms of a body, and which prism it is.
struct PrismCheck {
    int num_invalid = 0;  ///< prisms with a Jacobian <= 0 at a corner or quadrature point
    int worst_prism_idx = -1;
    double min_jacobian = 0;  ///< m^3
};
PrismCheck check_prisms(const Eigen::Ref<const Points>& volume_vertices, const Eigen::Ref<const Prisms>& prisms);
/// Smallest prism_min_scaled_jacobian over all prisms.
double min_scaled_jacobian(const Eigen::Ref<const Points>& volume_vertices, const Eigen::Ref<const Prisms>& prisms);

}  // namespace ndg
