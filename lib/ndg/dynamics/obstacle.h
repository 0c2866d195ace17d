// SPDX-License-Identifier: Apache-2.0
// Things that bodies meet: closed surfaces of triangles that move as they are told, or by themselves.
#pragma once

#include "ndg/geometry/triangle_mesh.h"

#include <string>
#include <vector>

namespace ndg {

/// A half space, as far as it matters: a square of triangles with sides of about `edge`, normal +y, about the origin,
/// closed by a pyramid below a quarter as deep as it is wide. Beyond the square there is nothing.
TriangleMesh plane_shape(double size, double edge);
/// An icosphere about the origin with edges of at most about `edge`. Vertices lie on the sphere, triangles inside it by
/// up to edge^2 / (6 radius).
TriangleMesh sphere_shape(double radius, double edge);
/// About the y axis, the two hemispheres' centres `length` apart and as far from the origin.
TriangleMesh capsule_shape(double radius, double length, double edge);

/// Cuboid about the origin, of so long sides.
TriangleMesh box_shape(const Eigen::Vector3d& size, double edge);

/// Where an obstacle is at a time.
struct ObstacleKey {
    double time = 0;  ///< s
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

struct Obstacle {
    std::string name;
    TriangleMesh shape;             ///< closed, outward, in its own frame
    std::vector<ObstacleKey> keys;  ///< at least one; between two: straight, and about one axis; ascending
    /// Of its origin, m/s, and of rotation, rad/s, in the world: from the last key on, or of one that moves by itself
    /// at the start.
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), angular_velocity = Eigen::Vector3d::Zero();
    /// Coefficient, negative: as all obstacles.
    double friction = -1;

    /// Moves by itself from its first key on: a thrown thing of one elastic material.
    bool free = false;
    double mass_kg = 1;
    double young_pascal = 1e6;

    /// A joint with whose surroundings it moves: what is said above of the world is then meant of the body at rest.
    std::string follows;

    Eigen::Isometry3d world_from_obstacle(double time) const;
    /// Vertices at a time. `world_from_followed`: motion of the joint from rest.
    Points vertices(double time, const Eigen::Isometry3d& world_from_followed = Eigen::Isometry3d::Identity()) const;
};

/// A thrown thing: tetrahedra between its surface and one vertex inside, the last, which must see all of the surface
/// from inside. Stiff tetrahedra stand for a rigid body: six times as few unknowns would do, but contact, inertia and
/// solver are those of flesh.
struct ObstacleSolid {
    Points vertices;  ///< in the obstacle's frame, the surface's first
    Tetrahedra tetrahedra;
    Eigen::VectorXd masses;  ///< kg; three fifths on the surface, which gives the solid's moments of inertia
};
/// Throws Error where the centre of the volume does not see a triangle from inside.
ObstacleSolid solid_of(const TriangleMesh& shape, double mass_kg);

}  // namespace ndg
