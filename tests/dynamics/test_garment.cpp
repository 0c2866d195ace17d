// SPDX-License-Identifier: Apache-2.0
// Tight sleeves on soft limbs.
#include "contact_world.h"

#include "ndg/core/error.h"
#include "ndg/geometry/section_hull.h"
#include "ndg/geometry/triangle_crossings.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using test::World;
using test::WorldOptions;

namespace {

constexpr double radius = 0.045, bone = 0.015, length = 0.3;

/// A limb along x: soft around a bone.
test::SoftBody limb()
{
    return test::brick_body(
        {2, 14, 10},
        [](const Eigen::Vector3d& s) -> Eigen::Vector3d {
            // A little uneven, for the test of crossings takes edges in one line for crossed.
            const double angle = 2 * M_PI * s[1], uneven = 1 + 0.01 * std::sin(40 * s[2]) * std::cos(5 * angle);
            const double r = bone + (radius - bone) * s[0] * uneven;
            return {length * s[2], r * std::cos(angle), r * std::sin(angle)};
        },
        [](const Eigen::Vector3d& s) { return s[0] == 0; }, true);
}

Eigen::Vector3d joint(const std::string& name)
{
    if (name != "shoulder" && name != "elbow") throw InputError("no joint " + name);
    return {name == "elbow" ? length : 0, 0, 0};
}

GarmentPlan sleeve()
{
    GarmentPlan plan;
    plan.name = "sleeve";
    plan.from_joint = "shoulder";
    plan.to_joint = "elbow";
    plan.from = 0.3;
    plan.to = 0.7;
    plan.edge = 0.02;
    plan.shrink_seconds = 0.2;
    return plan;
}

double girth(const Points& vertices, const Triangles& triangles, double x)
{
    return section_hull(vertices, triangles, {x, 0, 0}, Eigen::Vector3d::UnitX()).girth();
}

}  // namespace

TEST_CASE("A sleeve is made outside the limb, and as tight at rest as asked for")
{
    const test::SoftBody body = limb();
    const Garment garment = make_garment(sleeve(), body.rest, body.skin, joint, 2e-3);
    CHECK(crossing_triangles(garment.worn.vertices, garment.worn.triangles, body.rest, body.skin).empty());
    const double around = girth(body.rest, body.skin, 0.15);
    CHECK(around == Approx(2 * M_PI * radius).epsilon(0.02));
    CHECK(girth(garment.worn.vertices, garment.worn.triangles, 0.15) > around);
    CHECK(girth(garment.rest, garment.worn.triangles, 0.15) == Approx(0.9 * around).epsilon(0.02));
    CHECK((garment.rest_at(0) - garment.worn.vertices).norm() == 0);
    CHECK((garment.rest_at(1) - garment.rest).norm() < 1e-14);
    // All of its area faces outwards.
    const Points normals = triangle_normals(garment.worn.vertices, garment.worn.triangles);
    for (Eigen::Index t = 0; t < normals.rows(); ++t) {
        Eigen::RowVector3d out = garment.worn.vertices.row(garment.worn.triangles(t, 0));
        out[0] = 0;
        CHECK(normals.row(t).dot(out) > 0);
    }
    const double area = 0.4 * length * 2 * M_PI * (radius + 5e-3);
    CHECK(garment.masses().sum() == Approx(400 * 5e-4 * area).epsilon(0.05));
    GarmentPlan beyond = sleeve();
    beyond.to = 1.5;
    CHECK_THROWS_AS(make_garment(beyond, body.rest, body.skin, joint, 2e-3), InputError);
}

TEST_CASE("Cloth stretches like a sheet of its material")
{
    // A tube of rest girth g pulled 5 % wider all along: its energy is about that of a strip, E t area (0.05)^2 / 2.
    const test::SoftBody body = limb();
    Garment garment = make_garment(sleeve(), body.rest, body.skin, joint, 2e-3);
    const int count = static_cast<int>(garment.worn.vertices.rows());
    ElasticBody elastic(count, 0);
    elastic.add(cloth_term(garment, 0, count));
    elastic.set_rest(garment.rest);
    const Objective objective(elastic);
    CHECK(std::abs(objective.energy(garment.rest)) < 1e-12);
    Points wide = garment.rest;
    wide.rightCols<2>() *= 1.05;
    const double area = vertex_areas(garment.rest, garment.worn.triangles).sum();
    // Held in length: E t / (1 - nu^2) with the lattice's nu = 1/3.
    const double strain = 0.05, expected = 0.5 * garment.material.young_pascal * garment.material.thickness /
                                           (1 - 1.0 / 9) * strain * strain * area;
    CHECK(objective.energy(wide) == Approx(expected).epsilon(0.25));
}

TEST_CASE("A sleeve of nine tenths makes a limb thinner, stays outside of it and lets go nowhere")
{
    const test::SoftBody body = limb();
    WorldOptions options;
    options.young_pascal = 1e4;
    options.gravity.setZero();
    World world(body, {}, {make_garment(sleeve(), body.rest, body.skin, joint, 2e-3)}, options);
    world.run(0.35);
    const double before = girth(body.rest, body.skin, 0.15), after = girth(world.body_positions(), body.skin, 0.15);
    INFO(before << " m before, " << after << " m after");
    CHECK(after < 0.985 * before);
    CHECK(after > 0.85 * before);
    // Flesh is pushed out beside it.
    CHECK(girth(world.body_positions(), body.skin, 0.05) > before);
    const Interaction::Rows rows = world.interaction().garment_rows()[0];
    const Points cloth = world.state().positions.middleRows(rows.first, rows.count);
    const Garment& garment = world.interaction().garments()[0];
    CHECK(girth(cloth, garment.worn.triangles, 0.15) > after);
    // Forces on skin and cloth balance.
    CHECK((world.force_on(rows.first, rows.count) + world.force_on(0, rows.first)).norm() < 1e-9);
}
