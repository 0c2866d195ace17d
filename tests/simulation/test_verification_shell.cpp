// SPDX-License-Identifier: Apache-2.0
// The skin's energies, as assembled, on sheets whose angles and lengths are known: rolled to a cylinder and stretched.
#include "ndg/elastic/layered_body.h"
#include "ndg/elastic/objective.h"
#include "verification_bodies.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

constexpr double stretch_stiffness = 3e-2, bend_stiffness = 2e-3;

/// A sheet of 8 x 5 rectangles of 12 by 9 mm, each with a diagonal, on top of flesh that weighs nothing.
struct Sheet {
    test::Block block;
    Template body;
    double width = 0.012, length = 0.009;

    Sheet()
    {
        block.cells << 8, 5, 2;
        block.size << 8 * width, 5 * length, 0.01;
        body = block.body();
    }
    /// Every skin vertex (i, j) goes where `place` says; the flesh goes along below.
    template <class Place>
    Points placed(const Place& place) const
    {
        Points x = body.rest.volume_vertices;
        for (int i = 0; i <= block.cells(0); ++i) {
            for (int j = 0; j <= block.cells(1); ++j) {
                for (int k = 0; k <= 2; ++k) {
                    x.row(block.vertex(i, j, k)) = place(i, j) - Eigen::RowVector3d(0, 0, 0.005 * (2 - k));
                }
            }
        }
        return x;
    }
    ElasticBody elastic(double k_stretch, double k_bend) const
    {
        MaterialOptions material = test::bare_flesh(1e-12, 1e-12, 0.47);
        material.stretch_stiffness = k_stretch;
        material.bend_stiffness = k_bend;
        return layered_body(body, material);
    }
};

/// Energy and virtual work of the forces when the sheet moves from `x` along `change`.
std::pair<double, double> energy_and_work(const ElasticBody& elastic, const Points& x, const Points& change)
{
    const Objective objective(elastic);
    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    double work = 0;
    for (std::size_t i = 0; i < objective.vertices().size(); ++i) {
        work += change.row(objective.vertices()[i]).dot(gradient.segment<3>(3 * static_cast<Eigen::Index>(i)));
    }
    return {objective.energy(x), work};
}

/// Rolled about the y axis so that neighbouring strips, which stay flat and keep their width, meet at `turn`; positive
/// with the skin outside.
Eigen::RowVector3d rolled(const Sheet& sheet, int i, int j, double turn)
{
    if (turn == 0) return {sheet.width * i, sheet.length * j, 0};
    const double radius = 0.5 * sheet.width / std::sin(0.5 * turn), angle = turn * (i - 4);
    return {radius * std::sin(angle), sheet.length * j, radius * (std::cos(angle) - 1)};
}

}  // namespace

TEST_CASE("A sheet rolled to a cylinder has the bending energy of its creases, and of its curvature")
{
    // The strips between creases are flat; a crease is made of edges of length b whose two triangles have areas
    // a b / 2, so each costs 1/2 k_b b^2 / (a b / 3) turn^2 = 3/2 k_b (b / a) turn^2 (NDG equation 5).
    Sheet sheet;
    const int num_creases = (sheet.block.cells(0) - 1) * sheet.block.cells(1);
    const double stiffness = 1.5 * bend_stiffness * sheet.length / sheet.width * num_creases;
    for (const double rest_turn : {0.0, 0.25}) {
        sheet.body.rest.volume_vertices = sheet.placed([&](int i, int j) { return rolled(sheet, i, j, rest_turn); });
        const ElasticBody elastic = sheet.elastic(0, bend_stiffness);
        for (const double turn : {-0.4, -0.02, 0.02, 0.5}) {
            CAPTURE(rest_turn, turn);
            const auto at = [&](double angle) {
                return sheet.placed([&](int i, int j) { return rolled(sheet, i, j, angle); });
            };
            const Points change = (at(turn + 1e-6) - at(turn - 1e-6)) / 2e-6;
            const auto [energy, moment] = energy_and_work(elastic, at(turn), change);
            REQUIRE(energy == Approx(stiffness * (turn - rest_turn) * (turn - rest_turn)).epsilon(1e-9));
            REQUIRE(moment == Approx(2 * stiffness * (turn - rest_turn)).epsilon(1e-6));
            if (rest_turn != 0) continue;
            // Per area of the sheet that is 3/2 k_b / R^2, up to second order in the turn.
            const double radius = 0.5 * sheet.width / std::sin(0.5 * std::abs(turn));
            const double area = sheet.width * sheet.length * num_creases;
            REQUIRE(energy == Approx(1.5 * bend_stiffness * area / (radius * radius)).epsilon(0.1 * turn * turn));
        }
    }
}

TEST_CASE("The other diagonals and directions of a rolled sheet cost nothing")
{
    // Rolled about the x axis instead, the creases are the edges across.
    Sheet sheet;
    const double turn = 0.3, radius = 0.5 * sheet.length / std::sin(0.5 * turn);
    const Points x = sheet.placed([&](int i, int j) -> Eigen::RowVector3d {
        return {sheet.width * i, radius * std::sin(turn * j), radius * (std::cos(turn * j) - 1)};
    });
    const int num_creases = sheet.block.cells(0) * (sheet.block.cells(1) - 1);
    const auto [energy, work] = energy_and_work(sheet.elastic(0, bend_stiffness), x, Points::Zero(x.rows(), 3));
    REQUIRE(energy == Approx(1.5 * bend_stiffness * sheet.width / sheet.length * num_creases * turn * turn));
    REQUIRE(work == 0);
    // Rigidly moved, stretched or sheared in its plane, a flat sheet has no bending energy.
    const Points flat = sheet.placed([&](int i, int j) -> Eigen::RowVector3d {
        return {1.2 * sheet.width * i + 0.3 * sheet.length * j, 0.9 * sheet.length * j, 0.4 * sheet.length * j};
    });
    REQUIRE(energy_and_work(sheet.elastic(0, bend_stiffness), flat, flat).first < 1e-12);
}

TEST_CASE("A flat sheet in a uniform stretch: energy and tension from its three families of edges")
{
    const Sheet sheet;
    const ElasticBody elastic = sheet.elastic(stretch_stiffness, 0);
    const int nx = sheet.block.cells(0), ny = sheet.block.cells(1);
    const double a = sheet.width, b = sheet.length;
    // Edges with two triangles: along x, along y, diagonals.
    const Eigen::Vector2d directions[3] = {{a, 0}, {0, b}, {a, b}};
    const int counts[3] = {nx * (ny - 1), (nx - 1) * ny, nx * ny};
    for (const double x_stretch : {0.85, 1.2}) {
        for (const double shear : {0.0, 0.25}) {
            CAPTURE(x_stretch, shear);
            Eigen::Matrix2d f;
            f << x_stretch, shear, 0, 1.1;
            const auto energy_of = [&](const Eigen::Matrix2d& deformation) {
                double sum = 0;
                for (int family = 0; family < 3; ++family) {
                    const double strain = (deformation * directions[family]).norm() / directions[family].norm() - 1;
                    sum += counts[family] * 0.5 * stretch_stiffness * strain * strain;
                }
                return sum;
            };
            const auto place = [&](const Eigen::Matrix2d& deformation) {
                return sheet.placed([&](int i, int j) -> Eigen::RowVector3d {
                    const Eigen::Vector2d p = deformation * Eigen::Vector2d(a * i, b * j);
                    return {p.x(), p.y(), 0};
                });
            };
            const Points x = place(f);
            for (int row = 0; row < 2; ++row) {
                for (int column = 0; column < 2; ++column) {
                    const Eigen::Matrix2d change = Eigen::Vector2d::Unit(row) * Eigen::RowVector2d::Unit(column);
                    const auto [energy, work] = energy_and_work(elastic, x, place(f + change) - x);
                    REQUIRE(energy == Approx(energy_of(f)).epsilon(1e-9));
                    const double expected = (energy_of(f + 1e-6 * change) - energy_of(f - 1e-6 * change)) / 2e-6;
                    REQUIRE(work == Approx(expected).epsilon(1e-6).margin(1e-9));
                }
            }
            // The pull over a cut across x: every edge that crosses it pulls with k (l - l0) / l0^2 along itself.
            const Objective objective(elastic);
            Eigen::VectorXd gradient, absolute;
            objective.gradient(x, gradient, absolute);
            Eigen::Vector2d pull = Eigen::Vector2d::Zero(), expected = Eigen::Vector2d::Zero();
            for (int i = 3; i <= nx; ++i) {
                for (int j = 0; j <= ny; ++j) {
                    pull += gradient.segment<2>(3 * (sheet.block.vertex(i, j, 2) - objective.vertices().front()));
                }
            }
            for (const int family : {0, 2}) {
                const Eigen::Vector2d edge = f * directions[family];
                const double rest = directions[family].norm();
                const int crossing = family == 0 ? ny - 1 : ny;
                expected += crossing * stretch_stiffness * (edge.norm() - rest) / (rest * rest) * edge.normalized();
            }
            REQUIRE(expected.norm() > 0.1);
            REQUIRE((pull - expected).norm() < 1e-9 * expected.norm());
        }
    }
}
