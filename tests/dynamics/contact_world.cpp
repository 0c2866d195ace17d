// SPDX-License-Identifier: Apache-2.0
#include "contact_world.h"

#include "ndg/elastic/flesh_term.h"
#include "ndg/elastic/materials.h"
#include "ndg/elastic/neo_hookean_lanes.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/triangle_crossings.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <map>

namespace ndg::test {

namespace {

/// Faces of one tetrahedron alone, outward.
Triangles boundary(const Tetrahedra& tetrahedra)
{
    constexpr int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    std::map<std::array<int, 3>, std::pair<int, Eigen::RowVector3i>> count;
    for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
        for (const auto& face : faces) {
            std::array<int, 3> key{tetrahedra(t, face[0]), tetrahedra(t, face[1]), tetrahedra(t, face[2])};
            const Eigen::RowVector3i outward(key[0], key[1], key[2]);
            std::sort(key.begin(), key.end());
            auto& entry = count[key];
            ++entry.first;
            entry.second = outward;
        }
    }
    std::vector<Eigen::RowVector3i> outer;
    for (const auto& [key, entry] : count) {
        if (entry.first == 1) outer.push_back(entry.second);
    }
    Triangles triangles(outer.size(), 3);
    for (int i = 0; i < int(outer.size()); ++i) triangles.row(i) = outer[i];
    return triangles;
}

}  // namespace

SoftBody brick_body(const Eigen::Vector3i& cells, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& place,
                    const std::function<bool(const Eigen::Vector3d&)>& held, bool around)
{
    const Eigen::Vector3i points = cells + Eigen::Vector3i(1, around ? 0 : 1, 1);
    const auto index = [&](int i, int j, int k) { return (i * points[1] + j % points[1]) * points[2] + k; };
    std::vector<Eigen::Vector3d> corners;
    for (int i = 0; i < points[0]; ++i)
        for (int j = 0; j < points[1]; ++j)
            for (int k = 0; k < points[2]; ++k)
                corners.push_back(Eigen::Vector3d(i, j, k).cwiseQuotient(cells.cast<double>()));
    std::vector<int> number(corners.size());
    SoftBody body;
    body.rest.resize(static_cast<Eigen::Index>(corners.size()), 3);
    int next = 0;
    for (const bool pass : {true, false}) {
        for (std::size_t v = 0; v < corners.size(); ++v) {
            if ((held && held(corners[v])) != pass) continue;
            number[v] = next;
            body.rest.row(next++) = place(corners[v]).transpose();
        }
        if (pass) body.num_held = next;
    }
    // Six tetrahedra about the brick's diagonal, one for each order of the axes.
    std::vector<Eigen::RowVector4i> tetrahedra;
    for (int i = 0; i < cells[0]; ++i)
        for (int j = 0; j < cells[1]; ++j)
            for (int k = 0; k < cells[2]; ++k) {
                std::array<int, 3> axes{0, 1, 2};
                do {
                    Eigen::Vector3i at(i, j, k);
                    Eigen::RowVector4i cell;
                    cell[0] = number[index(at[0], at[1], at[2])];
                    for (int a = 0; a < 3; ++a) {
                        ++at[axes[a]];
                        cell[a + 1] = number[index(at[0], at[1], at[2])];
                    }
                    const auto corner = [&](int a) -> Eigen::Vector3d { return body.rest.row(cell[a]); };
                    if (tetrahedron_volume(corner(0), corner(1), corner(2), corner(3)) < 0) std::swap(cell[2], cell[3]);
                    tetrahedra.push_back(cell);
                } while (std::next_permutation(axes.begin(), axes.end()));
            }
    body.tetrahedra.resize(static_cast<Eigen::Index>(tetrahedra.size()), 4);
    for (int t = 0; t < int(tetrahedra.size()); ++t) body.tetrahedra.row(t) = tetrahedra[t];
    const Triangles all = boundary(body.tetrahedra);
    body.skin.resize(all.rows(), 3);
    int count = 0;
    for (Eigen::Index t = 0; t < all.rows(); ++t) {
        if (all.row(t).maxCoeff() >= body.num_held) body.skin.row(count++) = all.row(t);
    }
    body.skin.conservativeResize(count, 3);
    return body;
}

SoftBody box_body(const Eigen::Vector3i& cells, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                  const std::function<bool(const Eigen::Vector3d&)>& held)
{
    return brick_body(
        cells, [&](const Eigen::Vector3d& s) -> Eigen::Vector3d { return low + s.cwiseProduct(high - low); }, held);
}

Obstacle make_obstacle(const std::string& name, TriangleMesh shape, const Eigen::Vector3d& position)
{
    Obstacle obstacle;
    obstacle.name = name;
    obstacle.shape = std::move(shape);
    obstacle.keys.push_back({0, position, Eigen::Quaterniond::Identity()});
    return obstacle;
}

Obstacle ground(double height, double size)
{
    return make_obstacle("ground", plane_shape(size, size / 8), {0, height, 0});
}

World::World(SoftBody body, std::vector<Obstacle> obstacles, std::vector<Garment> garments, const WorldOptions& options)
    : body_(std::move(body)),
      options_(options),
      interaction_(std::move(obstacles), std::move(garments),
                   {"body", static_cast<int>(body_.rest.rows()), body_.num_held, body_.skin}),
      elastic_(interaction_.num_vertices(), interaction_.num_given())
{
    const Tetrahedra cells = body_.tetrahedra.array() + interaction_.body_begin();
    const Lame lame = lame_parameters(options.young_pascal, options.poisson_ratio);
    elastic_.add(std::make_unique<FleshTerm<NeoHookeanLanes, TetrahedronElement>>(
        cells, std::vector<Lame>(static_cast<std::size_t>(cells.rows()), lame), 1.0, interaction_.num_vertices()));
    interaction_.add_terms(elastic_);
    scene_ = std::make_unique<ContactScene>(elastic_, interaction_.surfaces(), options.contact);

    Eigen::VectorXd body_masses = Eigen::VectorXd::Zero(body_.rest.rows());
    const Eigen::VectorXd volumes = tetrahedron_volumes(body_.rest, body_.tetrahedra);
    for (Eigen::Index t = 0; t < volumes.size(); ++t) {
        for (int a = 0; a < 4; ++a) body_masses[body_.tetrahedra(t, a)] += options.density * volumes[t] / 4;
    }
    masses_ = interaction_.masses(body_masses);
    ImplicitEulerOptions euler;
    euler.time_step_seconds = options.time_step;
    euler.newton.relative_tolerance = options.tolerance;
    euler.newton.absolute_tolerance_newton = 1e-9;
    euler_ = std::make_unique<ImplicitEuler>(elastic_, masses_, euler);
    euler_->set_loads(Eigen::VectorXd::Zero(masses_.size()), masses_ * options.gravity.transpose());
    elastic_.set_rest(interaction_.rest(body_.rest));
    interaction_.set_time(0);
    state_ = interaction_.start(body_.rest, Points::Zero(body_.rest.rows(), 3));
    check_apart(scene_->surfaces(), state_.positions, interaction_.num_given());
}

void World::step(const std::function<Eigen::Vector3d(int)>& held)
{
    time_ = ++steps_ * options_.time_step;
    Points start = state_.positions + options_.time_step * state_.velocities;
    start.topRows(interaction_.num_given()) = state_.positions.topRows(interaction_.num_given());
    interaction_.set_obstacles(time_, start);
    interaction_.set_time(time_);
    if (held) {
        for (int v = 0; v < body_.num_held; ++v) start.row(interaction_.body_begin() + v) = held(v).transpose();
    }
    const NewtonResult result = euler_->step(state_, start, time_, scene_.get());
    iterations_ += result.iterations;
    INFO("at " << time_ << " s: " << describe(result.stop) << ", residual " << result.residual_relative << ", "
               << scene_->counts().elements << " elements, " << scene_->counts().rounds << " rounds");
    REQUIRE(result.converged());
    for (const Penetration& penetration :
         find_penetrations(scene_->surfaces(), state_.positions, interaction_.num_given())) {
        FAIL(penetration.inner << " in " << penetration.outer << ": " << penetration.vertices << " vertices, "
                               << penetration.depth_metre << " m at " << time_ << " s");
    }
    for (const ContactSurface& surface : scene_->surfaces()) {
        INFO(surface.name << " at " << time_ << " s");
        if (surface.meets_itself) REQUIRE(crossing_triangles(state_.positions, surface.triangles).empty());
    }
}

void World::run(double seconds)
{
    const int count = static_cast<int>(std::lround(seconds / options_.time_step));
    for (int i = 0; i < count; ++i) step();
}

Points World::obstacle_positions(int obstacle) const
{
    const Interaction::Rows& rows = interaction_.obstacle_rows()[static_cast<std::size_t>(obstacle)];
    return state_.positions.middleRows(rows.first, rows.count);
}

}  // namespace ndg::test
