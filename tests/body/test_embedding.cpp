// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/embedding.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/prism.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace ndg;

namespace {

/// The tube with every volume vertex moved a little, so that prism sides are no longer flat.
Template rough_tube()
{
    Template tube = test::tube_template(7, 8);
    Random random(11, "roughness");
    for (Eigen::Index i = 0; i < tube.rest.volume_vertices.size(); ++i) {
        tube.rest.volume_vertices.data()[i] += random.uniform(-0.003, 0.003);
    }
    REQUIRE(check_prisms(tube.rest.volume_vertices, tube.prisms).num_invalid == 0);
    return tube;
}

Embedding embed(const Template& tube, const Points& points)
{
    return embed_points(points, tube.rest.volume_vertices, tube.prisms, tube.rest.interior_vertices, tube.tetrahedra,
                        tube.num_wrap_vertices());
}

/// Random points inside random prisms and tetrahedra, made from their shape functions.
Points inside_points(const Template& tube, int count)
{
    Random random(12, "points");
    Points points(count, 3);
    for (int i = 0; i < count; ++i) {
        double a = random.uniform(), b = random.uniform();
        if (a + b > 1.0) {
            a = 1.0 - a;
            b = 1.0 - b;
        }
        if (i % 2 == 0) {
            const auto p = static_cast<Eigen::Index>(random.below(static_cast<std::uint64_t>(tube.prisms.rows())));
            points.row(i) =
                prism_point(gather_prism(tube.rest.volume_vertices, tube.prisms, p), a, b, random.uniform());
            continue;
        }
        const auto t = static_cast<Eigen::Index>(random.below(static_cast<std::uint64_t>(tube.tetrahedra.rows())));
        const double height = std::cbrt(random.uniform());
        Eigen::Vector4d weights(1.0 - height, height * (1.0 - a - b), height * a, height * b);
        points.row(i).setZero();
        for (int k = 0; k < 4; ++k) {
            const int vertex = tube.tetrahedra(t, k);
            const int num_wrap = tube.num_wrap_vertices();
            points.row(i) += weights[k] * (vertex < num_wrap ? tube.rest.volume_vertices.row(vertex)
                                                             : tube.rest.interior_vertices.row(vertex - num_wrap));
        }
    }
    return points;
}

}  // namespace

TEST_CASE("Embedded points inside are reproduced and follow affine maps", "[embedding]")
{
    const Template tube = rough_tube();
    const Points points = inside_points(tube, 2000);
    const Embedding embedding = embed(tube, points);
    REQUIRE(embedding.elements.size() == 2000);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        CHECK(embedding.weights.row(i).sum() == Approx(1.0).margin(1e-12));
        CHECK(embedding.weights.row(i).minCoeff() > -1e-8);
        CHECK(embedding.distances[i] == 0.0);
        const int element = embedding.elements[i];
        if (element < tube.num_prisms()) {
            CHECK(embedding.vertices.row(i) == tube.prisms.row(element));
        } else {
            CHECK(embedding.weights.row(i).tail<2>().isZero());
        }
    }
    const auto& rest = tube.rest;
    const Points back = apply_embedding(embedding, rest.volume_vertices, rest.interior_vertices);
    CHECK((back - points).rowwise().norm().maxCoeff() < 1e-9);

    Eigen::Matrix3d linear;
    linear << 1.2, 0.3, -0.1, 0.2, 0.8, 0.4, -0.3, 0.1, 1.5;
    const Eigen::RowVector3d shift(0.4, -2.0, 1.0);
    const auto mapped = [&](const Points& x) { return Points((x * linear.transpose()).rowwise() + shift); };
    const Points moved = apply_embedding(embedding, mapped(rest.volume_vertices), mapped(rest.interior_vertices));
    CHECK((moved - mapped(points)).rowwise().norm().maxCoeff() < 1e-9);
}

TEST_CASE("The anatomy of the tube bends with it", "[embedding]")
{
    const Template tube = test::tube_template();
    const auto motions = forward_kinematics(tube.skeleton, tube.rest.joint_positions, test::tube_pose(0.6));
    const Points volume = linear_blend_skinning(tube.rest.volume_vertices, tube.volume_weights(), motions);
    const Points interior = linear_blend_skinning(tube.rest.interior_vertices, tube.interior_weights, motions);
    const Points moved = apply_embedding(tube.embedding, volume, interior);
    // The shaft's ends lie in regions that move rigidly: bottom with the upper arm, top with the forearm.
    CHECK((moved.row(0) - tube.anatomy_vertices.row(0)).norm() < 1e-9);
    const int top = tube.anatomy_parts[0].vertex_end - 1;
    const Eigen::Vector3d rest_top = tube.anatomy_vertices.row(top).transpose();
    const Eigen::Vector3d expected = motions[tube.skeleton.joint("left_forearm")] * rest_top;
    CHECK((moved.row(top).transpose() - expected).norm() < 1e-9);
}

TEST_CASE("Outside points take the nearest point of the volume and report the distance", "[embedding]")
{
    const Template tube = rough_tube();
    const auto& rest = tube.rest;
    Random random(13, "outside");
    Points points(200, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double angle = random.uniform(0.0, 6.28), radius = random.uniform(0.1, 0.3);
        points.row(i) << radius * std::cos(angle), random.uniform(0.2, 0.8), radius * std::sin(angle);
    }
    const Embedding embedding = embed(tube, points);
    const Points nearest = apply_embedding(embedding, rest.volume_vertices, rest.interior_vertices);
    const TriangleTree skin(rest.volume_vertices.bottomRows(tube.num_wrap_vertices()), tube.wrap_triangles);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double distance = embedding.distances[i];
        CHECK(distance == Approx(skin.closest(points.row(i).transpose()).distance).margin(1e-9));
        CHECK((nearest.row(i) - points.row(i)).norm() == Approx(distance).margin(1e-9));
        CHECK(embedding.weights.row(i).minCoeff() >= 0.0);
        CHECK(embedding.weights.row(i).sum() == Approx(1.0).margin(1e-12));
    }
}

TEST_CASE("The distance to a twisted side of a prism is the smallest over the prism", "[embedding]")
{
    Points vertices(6, 3);
    vertices << 0, 0.1, 1, 1, -0.2, 1.1, 0, 1, 0.9, 0, -0.1, 0, 1, 0.3, 0, 0.1, 1, 0;
    Prisms prism(1, 6);
    prism << 0, 1, 2, 3, 4, 5;
    REQUIRE(check_prisms(vertices, prism).num_invalid == 0);
    const PrismVertices corners = gather_prism(vertices, prism, 0);
    Random random(14, "sides");
    Points points(40, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double angle = random.uniform(0.0, 6.28);
        points.row(i) << 0.3 + 1.5 * std::cos(angle), 0.3 + 1.5 * std::sin(angle), random.uniform(-0.5, 1.5);
    }
    const Embedding embedding = embed_points(points, vertices, prism, Points(0, 3), Tetrahedra(0, 4), 3);
    constexpr int steps = 60;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        double sampled = std::numeric_limits<double>::infinity();
        for (int a = 0; a <= steps; ++a) {
            for (int b = 0; a + b <= steps; ++b) {
                for (int x = 0; x <= steps; ++x) {
                    const double n = steps;
                    sampled = std::min(sampled, (prism_point(corners, a / n, b / n, x / n) - points.row(i)).norm());
                }
            }
        }
        const double distance = embedding.distances[i];
        CHECK(distance <= sampled + 1e-9);
        CHECK(distance >= sampled - 2e-3);
    }
}

TEST_CASE("A point in a tetrahedron's neighbourhood finds its face", "[embedding]")
{
    Points vertices(4, 3);
    vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    Tetrahedra tetrahedron(1, 4);
    tetrahedron << 0, 1, 2, 3;
    Points points(3, 3);
    points << 0.25, 0.25, -0.5, 2.0, 0.0, 0.0, 0.25, 0.25, 0.25;
    const Embedding embedding = embed_points(points, vertices, Prisms(0, 6), Points(0, 3), tetrahedron, 4);
    CHECK(embedding.distances[0] == Approx(0.5));
    CHECK(embedding.weights(0, 0) == Approx(0.5));
    CHECK(embedding.weights(0, 3) == 0.0);
    CHECK(embedding.distances[1] == Approx(1.0));
    CHECK(embedding.weights(1, 1) == Approx(1.0));
    CHECK(embedding.distances[2] == 0.0);
}

TEST_CASE("The element of a shared point does not depend on threads", "[embedding]")
{
    const Template tube = rough_tube();
    const Points& points = tube.rest.volume_vertices;
    const Embedding all = embed(tube, points);
    const int threads = num_threads();
    set_num_threads(1);
    const Embedding single = embed(tube, points);
    set_num_threads(threads);
    CHECK(all.elements == single.elements);
    CHECK(all.weights == single.weights);
    for (const double distance : all.distances) CHECK(distance == 0.0);
    const Points back = apply_embedding(all, tube.rest.volume_vertices, tube.rest.interior_vertices);
    CHECK((back - points).rowwise().norm().maxCoeff() < 1e-9);
}

TEST_CASE("Embedding nothing gives nothing, and bad input is refused", "[embedding]")
{
    const Template tube = test::tube_template();
    CHECK(embed(tube, Points(0, 3)).elements.empty());
    Points points(1, 3);
    points << 0, 0.5, std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(embed(tube, points), Error);
    points(0, 2) = 0.0;
    CHECK_THROWS_AS(embed_points(points, Points(0, 3), Prisms(0, 6), Points(0, 3), Tetrahedra(0, 4), 0), Error);
    const Embedding embedding = embed(tube, points);
    CHECK_THROWS_AS(apply_embedding(embedding, Points(2, 3), Points(0, 3)), Error);
}
