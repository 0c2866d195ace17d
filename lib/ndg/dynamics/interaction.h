// SPDX-License-Identifier: Apache-2.0
// A body, what it meets and what it wears as one stack of vertices: [obstacles that move as they are told; the body's
// held vertices; its others; thrown solids; garments].
#pragma once

#include "ndg/dynamics/contact_surfaces.h"
#include "ndg/dynamics/garment.h"
#include "ndg/dynamics/obstacle.h"
#include "ndg/dynamics/step_hook.h"
#include "ndg/elastic/elastic_body.h"

#include <string>
#include <vector>

namespace ndg {

/// A body among its own vertices, held ones first.
struct ContactBody {
    std::string name = "body";
    int num_vertices = 0, num_held = 0;
    Triangles skin;
};

class Interaction {
public:
    /// Throws Error for a free obstacle that is no solid (obstacle.h).
    Interaction(std::vector<Obstacle> obstacles, std::vector<Garment> garments, ContactBody body);

    int num_vertices() const { return num_vertices_; }
    /// Of obstacles and held vertices: the first ones.
    int num_given() const { return body_begin_ + body_.num_held; }
    int body_begin() const { return body_begin_; }
    std::vector<ContactSurface> surfaces() const;

    /// The elasticity of solids and garments; that of the body is for the caller to add, at body_begin().
    void add_terms(ElasticBody& elastic);
    /// For ElasticBody::set_rest(); set_time() follows. `body`: at rest.
    Points rest(const Eigen::Ref<const Points>& body) const;
    /// Garments shrink: their terms' rest shape at a time.
    void set_time(double time);

    /// All at time 0, where the body is as given.
    DynamicState start(const Eigen::Ref<const Points>& positions, const Eigen::Ref<const Points>& velocities) const;
    /// Gives solids their places and velocities.
    void throw_solids(DynamicState& state) const;
    /// kg; given obstacles have none.
    Eigen::VectorXd masses(const Eigen::Ref<const Eigen::VectorXd>& body) const;
    /// Motions from rest of the joints that obstacles follow, one an obstacle (unused where it follows none).
    void set_followed(std::vector<Eigen::Isometry3d> world_from_followed);
    /// Obstacles that move as they are told, at a time, into their rows.
    void set_obstacles(double time, Points& positions) const;

    /// Rows of the stack of each obstacle and garment, in the order given.
    struct Rows {
        int first = 0, count = 0;
    };
    const std::vector<Obstacle>& obstacles() const { return obstacles_; }
    const std::vector<Garment>& garments() const { return garments_; }
    const std::vector<Rows>& obstacle_rows() const { return obstacle_rows_; }
    const std::vector<Rows>& garment_rows() const { return garment_rows_; }

private:
    std::vector<Obstacle> obstacles_;
    std::vector<ObstacleSolid> solids_;  ///< of every obstacle, empty for those that do not move by themselves
    std::vector<Garment> garments_;
    ContactBody body_;
    std::vector<Rows> obstacle_rows_, garment_rows_;
    int body_begin_ = 0, num_vertices_ = 0;
    std::vector<SkinTerm*> cloth_terms_;
    std::vector<Eigen::Isometry3d> world_from_followed_;
};

}  // namespace ndg
