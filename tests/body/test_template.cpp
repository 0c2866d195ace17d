// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/triangle_mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

using namespace ndg;

TEST_CASE("Layer prisms join the wraps, outer triangle first", "[template]")
{
    Triangles triangles(2, 3);
    triangles << 0, 1, 2, 1, 3, 2;
    Prisms expected(4, 6);
    expected << 4, 5, 6, 0, 1, 2, 5, 7, 6, 1, 3, 2, 8, 9, 10, 4, 5, 6, 9, 11, 10, 5, 7, 6;
    CHECK(layer_prisms(triangles, 4) == expected);
}

TEST_CASE("check_prisms finds the one prism that is flipped", "[template]")
{
    Points points(6, 3);
    points << 0, 0, 2, 1, 0, 2, 0, 1, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0;
    Prisms prism(1, 6);
    prism << 0, 1, 2, 3, 4, 5;
    const PrismCheck right = check_prisms(points, prism);
    CHECK(right.num_invalid == 0);
    CHECK(right.worst_prism_idx == 0);
    CHECK(right.min_jacobian == Approx(2.0));

    const Template tube = test::tube_template();
    const PrismCheck valid = check_prisms(tube.rest.volume_vertices, tube.prisms);
    CHECK(valid.num_invalid == 0);
    CHECK(valid.min_jacobian > 0.0);
    CHECK(min_scaled_jacobian(tube.rest.volume_vertices, tube.prisms) > 0.0);

    Prisms flipped = tube.prisms;
    std::swap(flipped(37, 0), flipped(37, 1));
    std::swap(flipped(37, 3), flipped(37, 4));
    const PrismCheck invalid = check_prisms(tube.rest.volume_vertices, flipped);
    CHECK(invalid.num_invalid == 1);
    CHECK(invalid.worst_prism_idx == 37);
    CHECK(invalid.min_jacobian < 0.0);
    CHECK(min_scaled_jacobian(tube.rest.volume_vertices, flipped) < 0.0);

    // One muscle-wrap vertex pushed through the skin spoils exactly prisms that have it.
    Points pushed = tube.rest.volume_vertices;
    const int vertex = tube.num_wrap_vertices() + 20;
    pushed.row(vertex).array() *= Eigen::Array<double, 1, 3>(2.0, 1.0, 2.0);
    const PrismCheck through = check_prisms(pushed, tube.prisms);
    CHECK(through.num_invalid > 0);
    CHECK((tube.prisms.row(through.worst_prism_idx).array() == vertex).any());

    pushed(vertex, 0) = std::numeric_limits<double>::quiet_NaN();
    CHECK(check_prisms(pushed, tube.prisms).num_invalid > 0);
    CHECK(check_prisms(pushed, Prisms(0, 6)).worst_prism_idx == -1);
}

TEST_CASE("The test tube is a valid layered body", "[template]")
{
    const auto [rings, segments] = GENERATE(table<int, int>({{3, 3}, {7, 8}, {4, 13}}));
    const Template tube = test::tube_template(rings, segments);
    const int num_wrap = rings * segments;
    REQUIRE(tube.num_wrap_vertices() == num_wrap);
    REQUIRE(tube.rest.skin_vertices.rows() == num_wrap + 2);
    REQUIRE(tube.num_prisms() == 4 * (rings - 1) * segments);
    REQUIRE(tube.fat_begin() == tube.num_prisms() / 2);
    CHECK(closed_surface_defect(tube.rest.skin_vertices, tube.skin_triangles).empty());
    CHECK(check_prisms(tube.rest.volume_vertices, tube.prisms).num_invalid == 0);
    for (int i = 0; i < num_wrap; ++i) {
        CHECK(tube.rest.volume_vertices.row(2 * num_wrap + i) == tube.rest.skin_vertices.row(tube.wrap_to_skin[i]));
    }

    // Tetrahedra are positive, fill the wrap, match at every face, and end at the wrap triangles and the two caps.
    Points vertices(num_wrap + tube.rest.interior_vertices.rows(), 3);
    vertices << tube.rest.volume_vertices.topRows(num_wrap), tube.rest.interior_vertices;
    const Eigen::VectorXd volumes = tetrahedron_volumes(vertices, tube.tetrahedra);
    for (const double volume : volumes) CHECK(volume > 0.0);
    const double polygon = 0.5 * segments * std::sin(2.0 * 3.14159265358979323846 / segments) * 0.03 * 0.03;
    CHECK(volumes.sum() == Approx(polygon).epsilon(1e-12));
    std::map<std::array<int, 3>, int> faces;
    for (Eigen::Index t = 0; t < tube.tetrahedra.rows(); ++t) {
        for (int left_out = 0; left_out < 4; ++left_out) {
            std::array<int, 3> face;
            for (int k = 0, n = 0; k < 4; ++k) {
                if (k != left_out) face[n++] = tube.tetrahedra(t, k);
            }
            std::sort(face.begin(), face.end());
            ++faces[face];
        }
    }
    int boundary = 0;
    for (const auto& [face, count] : faces) {
        CHECK(count <= 2);
        if (count == 1) ++boundary;
    }
    CHECK(boundary == tube.wrap_triangles.rows() + 2 * segments);
    for (Eigen::Index t = 0; t < tube.wrap_triangles.rows(); ++t) {
        std::array<int, 3> face = {tube.wrap_triangles(t, 0), tube.wrap_triangles(t, 1), tube.wrap_triangles(t, 2)};
        std::sort(face.begin(), face.end());
        CHECK(faces[face] == 1);
    }

    // Anatomy: closed, inside the layers meant for it.
    REQUIRE(tube.anatomy_parts.size() == 2);
    CHECK(closed_surface_defect(tube.anatomy_vertices, tube.anatomy_triangles).empty());
    for (const AnatomyPart& part : tube.anatomy_parts) {
        for (int i = part.vertex_begin; i < part.vertex_end; ++i) {
            CHECK(tube.embedding.distances[i] == 0.0);
            const int element = tube.embedding.elements[i];
            CHECK((part.layer == AnatomyLayer::bone ? element >= tube.num_prisms() : element < tube.fat_begin()));
        }
    }
}

TEST_CASE("Weights of volume vertices and prisms come from the skin", "[template]")
{
    const Template tube = test::tube_template();
    const SkinningWeights volume = tube.volume_weights();
    REQUIRE(volume.size() == tube.num_volume_vertices());
    const SkinningWeights prisms = tube.prism_weights();
    REQUIRE(prisms.size() == tube.num_prisms());
    const int arm = tube.skeleton.joint("left_upper_arm");
    const auto arm_weight = [&](const SkinningWeights& weights, Eigen::Index row) {
        double sum = 0.0;
        for (Eigen::Index k = 0; k < max_influences; ++k) {
            if (weights.joints(row, k) == arm) sum += weights.weights(row, k);
        }
        return sum;
    };
    for (Eigen::Index i = 0; i < volume.size(); ++i) {
        const int skin_vertex = tube.wrap_to_skin[i % tube.num_wrap_vertices()];
        CHECK(volume.weights.row(i) == tube.skin_weights.weights.row(skin_vertex));
    }
    for (Eigen::Index p = 0; p < prisms.size(); ++p) {
        double mean = 0.0;
        for (Eigen::Index k = 0; k < 6; ++k) mean += arm_weight(volume, tube.prisms(p, k)) / 6.0;
        CHECK(arm_weight(prisms, p) == Approx(mean).margin(1e-14));
        CHECK(prisms.weights.row(p).sum() == Approx(1.0).margin(1e-14));
    }
}

TEST_CASE("The tube's elbow bends the upper end and leaves the lower one", "[template]")
{
    const Template tube = test::tube_template();
    const auto motions = forward_kinematics(tube.skeleton, tube.rest.joint_positions, test::tube_pose(0.5));
    const Points posed = linear_blend_skinning(tube.rest.volume_vertices, tube.volume_weights(), motions);
    CHECK((posed.row(0) - tube.rest.volume_vertices.row(0)).norm() < 1e-14);
    const Eigen::Index top = tube.num_wrap_vertices() - 1;
    const Eigen::Vector3d elbow(0, 0.5, 0), rest = tube.rest.volume_vertices.row(top).transpose();
    const Eigen::Vector3d expected = elbow + Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) * (rest - elbow);
    CHECK((posed.row(top).transpose() - expected).norm() < 1e-14);
}
