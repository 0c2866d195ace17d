// SPDX-License-Identifier: Apache-2.0
// Small soft bodies of tetrahedra among obstacles and garments, through time.
#pragma once

#include "ndg/dynamics/contact_scene.h"
#include "ndg/dynamics/implicit_euler.h"
#include "ndg/dynamics/interaction.h"

#include <functional>
#include <memory>

namespace ndg::test {

/// Vertices with held ones first, tetrahedra, outer triangles.
struct SoftBody {
    Points rest;
    Tetrahedra tetrahedra;
    Triangles skin;
    int num_held = 0;
};

/// `cells` bricks along each axis, each of six tetrahedra; `place` maps [0, 1]^3 into space, `around`: the second axis
/// is closed; `held`: of corners in [0, 1]^3. Skin: the whole boundary but triangles with held corners alone.
SoftBody brick_body(const Eigen::Vector3i& cells, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& place,
                    const std::function<bool(const Eigen::Vector3d&)>& held, bool around = false);
/// A box between two corners, held where `held` says so; by default nowhere.
SoftBody box_body(const Eigen::Vector3i& cells, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                  const std::function<bool(const Eigen::Vector3d&)>& held = {});

struct WorldOptions {
    Eigen::Vector3d gravity = Eigen::Vector3d(0, -9.81, 0);
    double young_pascal = 2e4, poisson_ratio = 0.4, density = 1000, time_step = 1.0 / 120, tolerance = 1e-6;
    ContactSceneOptions contact;
};

class World {
public:
    World(SoftBody body, std::vector<Obstacle> obstacles, std::vector<Garment> garments = {},
          const WorldOptions& options = {});

    /// One time step, which must converge, after which no surface may pass through another nor the body through
    /// itself. `held`: where held vertices go; empty: they stay.
    void step(const std::function<Eigen::Vector3d(int)>& held = {});
    void run(double seconds);

    double time() const { return time_; }
    const DynamicState& state() const { return state_; }
    DynamicState& state() { return state_; }
    Interaction& interaction() { return interaction_; }
    const ContactScene& scene() const { return *scene_; }
    const Eigen::VectorXd& masses() const { return masses_; }
    Points body_positions() const { return state_.positions.middleRows(interaction_.body_begin(), body_.rest.rows()); }
    /// Of an obstacle's vertices.
    Points obstacle_positions(int obstacle) const;
    Eigen::Vector3d momentum() const { return state_.velocities.transpose() * masses_; }
    /// Sum of contact forces on vertices from `first`.
    Eigen::Vector3d force_on(int first, int count) const
    {
        return scene_->contact_forces(state_.positions).middleRows(first, count).colwise().sum().transpose();
    }
    int iterations() const { return iterations_; }

private:
    SoftBody body_;
    WorldOptions options_;
    Interaction interaction_;
    ElasticBody elastic_;
    Eigen::VectorXd masses_;
    std::unique_ptr<ContactScene> scene_;
    std::unique_ptr<ImplicitEuler> euler_;
    DynamicState state_;
    double time_ = 0;
    int steps_ = 0, iterations_ = 0;
};

Obstacle make_obstacle(const std::string& name, TriangleMesh shape, const Eigen::Vector3d& position);
/// The ground at a height, as wide as given.
Obstacle ground(double height = 0, double size = 1);

}  // namespace ndg::test
