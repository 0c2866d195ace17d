// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/interaction.h"

#include "ndg/core/error.h"
#include "ndg/elastic/flesh_term.h"
#include "ndg/elastic/materials.h"
#include "ndg/elastic/neo_hookean_lanes.h"

namespace ndg {

namespace {

/// Of thrown solids.
constexpr double solid_poisson_ratio = 0.3;

}  // namespace

Interaction::Interaction(std::vector<Obstacle> obstacles, std::vector<Garment> garments, ContactBody body)
    : obstacles_(std::move(obstacles)),
      solids_(obstacles_.size()),
      garments_(std::move(garments)),
      body_(std::move(body)),
      obstacle_rows_(obstacles_.size()),
      world_from_followed_(obstacles_.size(), Eigen::Isometry3d::Identity())
{
    const auto take = [&](Eigen::Index count) {
        const Rows rows{num_vertices_, static_cast<int>(count)};
        num_vertices_ += rows.count;
        return rows;
    };
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        if (!obstacles_[i].free) obstacle_rows_[i] = take(obstacles_[i].shape.vertices.rows());
    }
    body_begin_ = take(body_.num_vertices).first;
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        if (!obstacles_[i].free) continue;
        solids_[i] = solid_of(obstacles_[i].shape, obstacles_[i].mass_kg);
        obstacle_rows_[i] = take(solids_[i].vertices.rows());
    }
    for (const Garment& garment : garments_) garment_rows_.push_back(take(garment.worn.vertices.rows()));
}

std::vector<ContactSurface> Interaction::surfaces() const
{
    std::vector<ContactSurface> surfaces;
    const auto add = [&](const std::string& name, SurfaceKind kind, const Triangles& triangles, int first, bool itself,
                         double friction) {
        surfaces.push_back({name, kind, triangles.array() + first, itself, friction});
    };
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        add(obstacles_[i].name, SurfaceKind::obstacle, obstacles_[i].shape.triangles, obstacle_rows_[i].first, false,
            obstacles_[i].friction);
    }
    add(body_.name, SurfaceKind::skin, body_.skin, body_begin_, true, -1);
    for (std::size_t i = 0; i < garments_.size(); ++i) {
        add(garments_[i].name, SurfaceKind::cloth, garments_[i].worn.triangles, garment_rows_[i].first, true,
            garments_[i].friction);
    }
    return surfaces;
}

void Interaction::add_terms(ElasticBody& elastic)
{
    require(elastic.num_vertices() == num_vertices_ && elastic.num_fixed_vertices() == num_given(),
            "an elastic body of {} vertices, {} of them fixed, for {} and {}", elastic.num_vertices(),
            elastic.num_fixed_vertices(), num_vertices_, num_given());
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        if (!obstacles_[i].free) continue;
        const Tetrahedra cells = solids_[i].tetrahedra.array() + obstacle_rows_[i].first;
        const std::vector<Lame> materials(static_cast<std::size_t>(cells.rows()),
                                          lame_parameters(obstacles_[i].young_pascal, solid_poisson_ratio));
        elastic.add(
            std::make_unique<FleshTerm<NeoHookeanLanes, TetrahedronElement>>(cells, materials, 1.0, num_vertices_));
    }
    for (std::size_t i = 0; i < garments_.size(); ++i) {
        auto term = cloth_term(garments_[i], garment_rows_[i].first, num_vertices_);
        cloth_terms_.push_back(term.get());
        elastic.add(std::move(term));
    }
}

Points Interaction::rest(const Eigen::Ref<const Points>& body) const
{
    const Points still = Points::Zero(body.rows(), 3);
    return start(body, still).positions;
}

void Interaction::set_time(double time)
{
    Points rest = Points::Zero(num_vertices_, 3);
    for (std::size_t i = 0; i < garments_.size(); ++i) {
        rest.middleRows(garment_rows_[i].first, garment_rows_[i].count) = garments_[i].rest_at(time);
        cloth_terms_[i]->set_rest(rest);
    }
}

DynamicState Interaction::start(const Eigen::Ref<const Points>& positions,
                                const Eigen::Ref<const Points>& velocities) const
{
    require(positions.rows() == body_.num_vertices && velocities.rows() == body_.num_vertices,
            "{} positions and {} velocities of a body of {} vertices", positions.rows(), velocities.rows(),
            body_.num_vertices);
    DynamicState state{Points::Zero(num_vertices_, 3), Points::Zero(num_vertices_, 3)};
    set_obstacles(0, state.positions);
    state.positions.middleRows(body_begin_, body_.num_vertices) = positions;
    state.velocities.middleRows(body_begin_, body_.num_vertices) = velocities;
    throw_solids(state);
    for (std::size_t i = 0; i < garments_.size(); ++i) {
        state.positions.middleRows(garment_rows_[i].first, garment_rows_[i].count) = garments_[i].worn.vertices;
    }
    return state;
}

void Interaction::throw_solids(DynamicState& state) const
{
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        const Obstacle& obstacle = obstacles_[i];
        if (!obstacle.free) continue;
        const Eigen::Isometry3d world_from_obstacle = obstacle.world_from_obstacle(obstacle.keys.front().time);
        for (int v = 0; v < obstacle_rows_[i].count; ++v) {
            const Eigen::Vector3d arm = world_from_obstacle.linear() * solids_[i].vertices.row(v).transpose();
            state.positions.row(obstacle_rows_[i].first + v) = (world_from_obstacle.translation() + arm).transpose();
            state.velocities.row(obstacle_rows_[i].first + v) =
                (obstacle.velocity + obstacle.angular_velocity.cross(arm)).transpose();
        }
    }
}

Eigen::VectorXd Interaction::masses(const Eigen::Ref<const Eigen::VectorXd>& body) const
{
    Eigen::VectorXd masses = Eigen::VectorXd::Zero(num_vertices_);
    masses.segment(body_begin_, body_.num_vertices) = body;
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        if (obstacles_[i].free) masses.segment(obstacle_rows_[i].first, obstacle_rows_[i].count) = solids_[i].masses;
    }
    for (std::size_t i = 0; i < garments_.size(); ++i) {
        masses.segment(garment_rows_[i].first, garment_rows_[i].count) = garments_[i].masses();
    }
    return masses;
}

void Interaction::set_followed(std::vector<Eigen::Isometry3d> world_from_followed)
{
    require(world_from_followed.size() == obstacles_.size(), "motions of {} of {} obstacles",
            world_from_followed.size(), obstacles_.size());
    world_from_followed_ = std::move(world_from_followed);
}

void Interaction::set_obstacles(double time, Points& positions) const
{
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
        if (!obstacles_[i].free) {
            positions.middleRows(obstacle_rows_[i].first, obstacle_rows_[i].count) =
                obstacles_[i].vertices(time, world_from_followed_[i]);
        }
    }
}

}  // namespace ndg
