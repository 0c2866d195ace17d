// SPDX-License-Identifier: Apache-2.0
// A bent limb of two layers: the simulator's prisms, and finer ones on the same limb, against a standard finite element
// method; and how well the equilibrium is balanced.
#include "bending_simulation.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/simulation/simulator.h"
#include "support/support.h"
#include "verification_bodies.h"
#include "verification_reference.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <map>
#include <numeric>

using namespace ndg;

namespace {

constexpr double sixty_degrees = 1.0471975511965976;

/// A limb of 0.4 m, 0.16 m thick.
Template limb()
{
    Template tube = test::tube_template(9, 8);
    for (Points* points : {&tube.rest.volume_vertices, &tube.rest.skin_vertices, &tube.rest.interior_vertices,
                           &tube.rest.joint_positions}) {
        points->col(1) *= 0.4;
    }
    return tube;
}

std::vector<int> free_vertices(const Template& body)
{
    std::vector<int> vertices(body.num_volume_vertices() - body.num_wrap_vertices());
    std::iota(vertices.begin(), vertices.end(), body.num_wrap_vertices());
    return vertices;
}

/// Rest and deformed positions of the same flesh in finer prisms, four for one; only what layered_body() needs.
struct Flesh {
    Template body;
    Points positions;

    Flesh finer() const
    {
        const int num_wrap = body.num_wrap_vertices();
        const std::vector<MeshEdge> edges = mesh_edges(body.wrap_triangles, num_wrap);
        const int num_fine = num_wrap + static_cast<int>(edges.size());
        std::map<std::pair<int, int>, int> middles;
        Flesh fine;
        fine.body.rest.volume_vertices.resize(3 * num_fine, 3);
        fine.positions.resize(3 * num_fine, 3);
        for (int layer = 0; layer < 3; ++layer) {
            const auto fill = [&](const Points& from, Points& to) {
                to.middleRows(layer * num_fine, num_wrap) = from.middleRows(layer * num_wrap, num_wrap);
                for (std::size_t e = 0; e < edges.size(); ++e) {
                    const int middle = num_wrap + static_cast<int>(e), a = edges[e].v0, b = edges[e].v1;
                    middles[{std::min(a, b), std::max(a, b)}] = middle;
                    to.row(layer * num_fine + middle) =
                        0.5 * (from.row(layer * num_wrap + a) + from.row(layer * num_wrap + b));
                }
            };
            fill(body.rest.volume_vertices, fine.body.rest.volume_vertices);
            fill(positions, fine.positions);
        }
        fine.body.wrap_triangles.resize(4 * body.wrap_triangles.rows(), 3);
        Eigen::Index row = 0;
        for (Eigen::Index t = 0; t < body.wrap_triangles.rows(); ++t) {
            const int a = body.wrap_triangles(t, 0), b = body.wrap_triangles(t, 1), c = body.wrap_triangles(t, 2);
            const auto middle = [&](int v, int w) { return middles.at({std::min(v, w), std::max(v, w)}); };
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            fine.body.wrap_triangles.row(row++) << a, ab, ca;
            fine.body.wrap_triangles.row(row++) << ab, b, bc;
            fine.body.wrap_triangles.row(row++) << ca, bc, c;
            fine.body.wrap_triangles.row(row++) << ab, bc, ca;
        }
        for (int v = 0; v < num_fine; ++v) fine.body.wrap_to_skin.push_back(v);
        fine.body.prisms = layer_prisms(fine.body.wrap_triangles, num_fine);
        return fine;
    }

    /// Positions of the vertices of the coarsest flesh, which come first in every layer: muscle wrap, skin.
    Points outer(int num_coarse_wrap) const
    {
        const int num_wrap = body.num_wrap_vertices();
        Points result(2 * num_coarse_wrap, 3);
        result << positions.middleRows(num_wrap, num_coarse_wrap), positions.middleRows(2 * num_wrap, num_coarse_wrap);
        return result;
    }
};

}  // namespace

// Mean distances in mm: gradient skinning 3.5; prisms 2.9, 1.2 and 0.8 for 8, 16 and 32 vertices a ring. What stays is
// the thickness of the layers: with a finer reference the last is 0.9.
TEST_CASE("A limb bent by 60 degrees: prisms of two layers against quadratic tetrahedra")
{
    const Template tube = limb();
    const int num_wrap = tube.num_wrap_vertices();
    SimulationOptions options = test::bending_simulation();
    options.material = test::bare_flesh(45e3, 15e3, 0.47);
    options.newton.relative_tolerance = 1e-7;
    Simulator simulator(tube, options);
    simulator.set_body(tube.rest);
    const SimulationResult result = simulator.simulate(test::tube_pose(sixty_degrees));
    REQUIRE(result.newton.converged());

    const Flesh coarse{tube, result.vertices};
    const Flesh start{tube, simulator.start(test::tube_pose(sixty_degrees))};
    std::vector<Flesh> levels{coarse, coarse.finer(), coarse.finer().finer()};
    std::vector<double> energies{result.newton.energy_joule};
    for (std::size_t level = 1; level < levels.size(); ++level) {
        const ElasticBody elastic = layered_body(levels[level].body, options.material);
        const Objective objective(elastic);
        NewtonSolver solver(objective);
        const NewtonResult newton = solver.minimise(levels[level].positions, options.newton);
        REQUIRE(newton.converged());
        energies.push_back(newton.energy_joule);
    }

    const std::array<Lame, 2> lame{lame_parameters(45e3, 0.47), lame_parameters(15e3, 0.47)};
    const Flesh& split = levels[1];
    test::SolidMesh mesh = test::split_prisms(split.body.rest.volume_vertices, split.positions, split.body.prisms,
                                              split.body.fat_begin(), free_vertices(split.body))
                               .quadratic();
    const test::SolidEquilibrium solid = test::solve(mesh, lame);
    const Points expected = Flesh{split.body, mesh.positions}.outer(num_wrap);
    const auto mean_distance = [&](const Flesh& flesh) {
        return 1e3 * (flesh.outer(num_wrap) - expected).rowwise().norm().mean();
    };
    const double from_start = mean_distance(start);
    const std::vector<double> distances{mean_distance(levels[0]), mean_distance(levels[1]), mean_distance(levels[2])};
    CAPTURE(from_start, distances, energies, solid.energy);
    REQUIRE(distances[0] < from_start);
    REQUIRE(distances[1] < 0.6 * distances[0]);
    REQUIRE(distances[2] < 0.8 * distances[1]);
    REQUIRE(distances[2] < 1);
    REQUIRE(energies[2] == Approx(solid.energy).epsilon(0.06));
}

TEST_CASE("In equilibrium the forces vanish, in newtons and against what the elements pull, and so do the bones' sums")
{
    const Template tube = test::tube_template(12, 8);
    SimulationOptions options = test::bending_simulation();
    options.newton.relative_tolerance = 1e-7;  // the sums below are held against what is left
    Simulator simulator(tube, options);
    simulator.set_body(tube.rest);
    for (const double angle : {0.5, 1.2}) {
        CAPTURE(angle);
        const SimulationResult result = simulator.simulate(test::tube_pose(angle));
        REQUIRE(result.newton.converged());
        const Objective& objective = simulator.objective();
        Eigen::VectorXd gradient, absolute;
        objective.gradient(simulator.start(test::tube_pose(angle)), gradient, absolute);
        const double at_start = gradient.norm();
        objective.gradient(result.vertices, gradient, absolute);
        CAPTURE(at_start, gradient.norm(), absolute.norm());
        REQUIRE(gradient.norm() == Approx(result.newton.residual_newton));
        REQUIRE(gradient.norm() / absolute.norm() == Approx(result.newton.residual_relative));
        REQUIRE(result.newton.residual_relative <= options.newton.relative_tolerance);
        REQUIRE(gradient.norm() < 1e-4 * at_start);

        // No force acts from outside, so all that the bone wrap exerts on the flesh must cancel; half of it need not.
        const auto work = [&](int num_moved, const Eigen::Matrix3d& turn, const Eigen::RowVector3d& shift) {
            Points moved = result.vertices;
            moved.topRows(num_moved) = (moved.topRows(num_moved) * turn.transpose()).eval();
            moved.topRows(num_moved).rowwise() += shift;
            return objective.energy(moved);
        };
        const int all = tube.num_wrap_vertices();
        const double step = 1e-5;
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
            const auto force = [&](int num_moved) {
                const Eigen::RowVector3d shift = step * unit.transpose();
                return (work(num_moved, Eigen::Matrix3d::Identity(), shift) -
                        work(num_moved, Eigen::Matrix3d::Identity(), -shift)) /
                       (2 * step);
            };
            const auto moment = [&](int num_moved) {
                const auto turn = [&](double a) { return Eigen::AngleAxisd(a, unit).toRotationMatrix(); };
                return (work(num_moved, turn(step), Eigen::RowVector3d::Zero()) -
                        work(num_moved, turn(-step), Eigen::RowVector3d::Zero())) /
                       (2 * step);
            };
            const double residual_bound = 1e-4 + 10 * gradient.norm();
            REQUIRE(std::abs(force(all)) < residual_bound);
            REQUIRE(std::abs(moment(all)) < residual_bound);
            if (axis == 0) REQUIRE(std::abs(force(all / 2)) > 100 * residual_bound);
            if (axis == 2) REQUIRE(std::abs(moment(all / 2)) > 100 * residual_bound);
        }
    }
}
