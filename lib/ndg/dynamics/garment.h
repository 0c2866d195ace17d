// SPDX-License-Identifier: Apache-2.0
// Tight clothes: elastic shells that start outside the skin and shrink to less than its girth.
#pragma once

#include "ndg/elastic/skin_term.h"
#include "ndg/geometry/triangle_mesh.h"

#include <functional>
#include <memory>
#include <string>

namespace ndg {

/// Cloth of one elastic material; as a shell of triangles its edges carry what a continuous one would on average.
struct ClothMaterial {
    double young_pascal = 2e6;
    double thickness = 5e-4;  ///< m
    double density = 400;     ///< kg / m^3
};

/// What a garment is to be.
struct GarmentPlan {
    std::string name;
    /// A tube about the line between two joints, from one share of the way to another.
    std::string from_joint, to_joint;
    double from = 0.25, to = 0.75;
    double edge = 0.015;   ///< of its triangles, m
    double offset = 5e-3;  ///< of the tube from the skin's convex hull at the start, m
    /// A mesh of its own in place of the tube, in the world at the start, outside the skin.
    TriangleMesh mesh;
    /// Girth at rest, by the limb's; of a mesh its edges, by those it has.
    double rest_share = 0.9;
    double shrink_seconds = 0.5;  ///< from the size it is made in
    ClothMaterial material;
    double friction = -1;  ///< negative: as all garments
};

struct Garment {
    std::string name;
    TriangleMesh worn;  ///< as it starts, in the world
    Points rest;        ///< as it would be by itself once it has shrunk
    double shrink_seconds = 0.5;
    ClothMaterial material;
    double friction = -1;

    /// Rest shape at a time: from that it starts in to `rest`, smoothly.
    Points rest_at(double time) const;
    Eigen::VectorXd masses() const;  ///< of the vertices, kg
};

/// Where a joint is at the start; throws InputError for an unknown one.
using JointPlaces = std::function<Eigen::Vector3d(const std::string& joint)>;

/// The tube of a plan around a skin as it is posed at the start, or its mesh. The tube follows the convex hull of the
/// skin's sections and is moved farther out, up to 5 cm, until it keeps its distance from the skin between them. Throws
/// InputError, naming the garment, where a section misses the skin or other parts of the skin are in the way.
Garment make_garment(const GarmentPlan& plan, const Eigen::Ref<const Points>& skin_vertices,
                     const Eigen::Ref<const Triangles>& skin_triangles, const JointPlaces& joints,
                     double least_distance);

/// Stretching and bending of a garment among the vertices of a scene, its own from `first_vertex` on (skin_term.h):
/// edges of length l have sqrt(3)/2 E t l^2 (a lattice of equilateral triangles then stretches like a sheet of Young's
/// modulus E and thickness t), hinges E t^3 / (12 (1 - nu^2)). Edges of one triangle, the hems, carry nothing. Its rest
/// shape is set by set_rest() of all vertices, as the garment shrinks.
std::unique_ptr<SkinTerm> cloth_term(const Garment& garment, int first_vertex, int num_vertices);

}  // namespace ndg
