// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/dynamic_mesh.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/makehuman/makehuman.h"
#include "ndg/template_build/symmetric_remesh.h"
#include "support/support.h"
#include "template_build/doll.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

using namespace ndg;
using namespace ndg::test;

namespace {

Triangles of_region(const RemeshedSkin& skin, int region)
{
    std::vector<int> rows;
    for (std::size_t t = 0; t < skin.regions.size(); ++t)
        if (skin.regions[t] == region) rows.push_back(static_cast<int>(t));
    return skin.triangles(rows, Eigen::all);
}

double smallest_angle(const RemeshedSkin& skin, int region)
{
    const Triangles triangles = of_region(skin, region);
    double least = M_PI;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        least = std::min(least, DynamicMesh::min_angle(skin.vertices.row(triangles(t, 0)).transpose(),
                                                       skin.vertices.row(triangles(t, 1)).transpose(),
                                                       skin.vertices.row(triangles(t, 2)).transpose()));
    return least;
}

void check_mirror(const RemeshedSkin& skin, double tolerance)
{
    REQUIRE(static_cast<Eigen::Index>(skin.mirror.size()) == skin.vertices.rows());
    double worst = 0.0;
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        const int m = skin.mirror[v];
        REQUIRE(skin.mirror[m] == v);
        const Eigen::RowVector3d image(-skin.vertices(v, 0), skin.vertices(v, 1), skin.vertices(v, 2));
        worst = std::max(worst, (skin.vertices.row(m) - image).norm());
        if (m == v) CHECK(skin.vertices(v, 0) == 0.0);
    }
    CHECK(worst <= tolerance);
    std::set<std::array<int, 4>> triangles;  // smallest vertex first, region last
    const auto key = [](int a, int b, int c, int region) {
        std::array<int, 3> corners{a, b, c};
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        return std::array<int, 4>{corners[0], corners[1], corners[2], region};
    };
    constexpr std::array<int, 6> mirrored_region{0, 1, 3, 2, 5, 4};
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        triangles.insert(key(skin.triangles(t, 0), skin.triangles(t, 1), skin.triangles(t, 2), skin.regions[t]));
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t) {
        const auto m = [&](int k) { return skin.mirror[skin.triangles(t, k)]; };
        const auto region = static_cast<std::size_t>(skin.regions[t]);
        REQUIRE(triangles.count(key(m(2), m(1), m(0), mirrored_region[region])) == 1);
    }
}

/// Every region has one border with the body, a chain on its cutting plane.
void check_borders(const RemeshedSkin& skin, const Points& joint_positions, std::size_t least_vertices)
{
    CHECK(boundary_loops(of_region(skin, 0), static_cast<int>(skin.vertices.rows())).size() == 5);
    for (const CuttingPlane& plane : cutting_planes(joint_positions)) {
        INFO(skin_region_names[plane.region]);
        const auto loops = boundary_loops(of_region(skin, plane.region), static_cast<int>(skin.vertices.rows()));
        REQUIRE(loops.size() == 1);
        CHECK(loops[0].size() >= least_vertices);
        double farthest = 0.0;
        for (const int v : loops[0])
            farthest = std::max(farthest, std::abs((skin.vertices.row(v) - plane.point).dot(plane.normal)));
        CHECK(farthest < 2e-5);
    }
}

double farthest_from(const TriangleTree& tree, const Points& vertices)
{
    double farthest = 0.0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        farthest = std::max(farthest, tree.closest(vertices.row(v).transpose()).distance);
    return farthest;
}

constexpr double degree = M_PI / 180.0;

}  // namespace

TEST_CASE("symmetric remeshing of a doll")
{
    const Doll doll = make_doll();
    const auto& [vertices, triangles, joints] = doll.surface;
    const SymmetricRemesher remesher(vertices, triangles, doll.weights, joints);
    const TriangleTree tree(vertices, triangles);
    for (const int prisms : {4000, 9000}) {
        const double length = remesher.edge_length_for_prisms(prisms);
        const RemeshedSkin skin = remesher.remesh(length, 0.5);
        CHECK(std::abs(2.0 * skin.num_body_triangles() / prisms - 1.0) < 0.03);
        CHECK(closed_surface_defect(skin.vertices, skin.triangles).empty());
        CHECK(self_intersections(skin.vertices.cast<float>().cast<double>(), skin.triangles, true).empty());
        CHECK(smallest_angle(skin, 0) > 20.0 * degree);
        CHECK(farthest_from(tree, skin.vertices) < 1e-9);
        check_mirror(skin, 1e-9);
        check_borders(skin, joints, 7);
        CHECK(enclosed_volume(skin.vertices, skin.triangles) ==
              Approx(enclosed_volume(vertices, triangles)).epsilon(0.06));
        if (prisms > 5000) continue;
        const RemeshedSkin again = remesh_symmetric(vertices, triangles, doll.weights, joints, length, 0.5);
        CHECK(again.vertices == skin.vertices);
        CHECK(again.triangles == skin.triangles);
        CHECK(again.regions == skin.regions);
    }
    // Fewer triangles are kept on head, hands and toes.
    const RemeshedSkin more = remesher.remesh(0.03, 1.0), less = remesher.remesh(0.03, 0.3);
    CHECK(more.num_body_triangles() == less.num_body_triangles());
    CHECK(of_region(less, 1).rows() < 0.6 * of_region(more, 1).rows());
}

TEST_CASE("symmetric remeshing: asymmetric input")
{
    Doll doll = make_doll();
    // A swelling of 1 mm on one thigh: vertices there must lie on it, not on the mirror image of the other thigh.
    const Eigen::RowVector3d place(-0.19, 0.7, 0.0);
    Points swollen = doll.surface.vertices;
    const auto swell = [&](double height) {
        const Points normals = vertex_normals(doll.surface.vertices, doll.surface.triangles);
        for (Eigen::Index v = 0; v < swollen.rows(); ++v) {
            const double distance = (doll.surface.vertices.row(v) - place).norm();
            swollen.row(v) =
                doll.surface.vertices.row(v) + height * std::exp(-distance * distance / (0.06 * 0.06)) * normals.row(v);
        }
    };
    swell(0.001);
    const RemeshedSkin skin =
        remesh_symmetric(swollen, doll.surface.triangles, doll.weights, doll.surface.joint_positions, 0.03, 0.5);
    CHECK(farthest_from(TriangleTree(swollen, doll.surface.triangles), skin.vertices) < 1e-9);
    check_mirror(skin, 0.002);
    swell(0.02);
    CHECK_THROWS_WITH(SymmetricRemesher(swollen, doll.surface.triangles, doll.weights, doll.surface.joint_positions),
                      Catch::Contains("not symmetric") && Catch::Contains("mm"));
}

TEST_CASE("symmetric remeshing: bad input is named")
{
    const Doll doll = make_doll();
    const auto& [vertices, triangles, joints] = doll.surface;
    const SymmetricRemesher remesher(vertices, triangles, doll.weights, joints);
    CHECK_THROWS_AS(remesher.remesh(0.001, 0.5), InputError);
    CHECK_THROWS_AS(remesher.remesh(std::nan(""), 0.5), InputError);
    CHECK_THROWS_AS(remesher.remesh(0.03, 0.0), InputError);
    CHECK_THROWS_AS(remesher.edge_length_for_prisms(0), InputError);
    CHECK_THROWS_AS(remesher.edge_length_for_prisms(100), InputError);
    RowMatrix no_head = doll.weights;
    no_head.col(0) += no_head.col(8);
    no_head.col(8).setZero();
    REQUIRE(doll.weights.col(8).sum() > 1.0);
    CHECK_THROWS_WITH(SymmetricRemesher(vertices, triangles, no_head, joints), Catch::Contains("head"));
    CHECK_THROWS_WITH(SymmetricRemesher(vertices, triangles.topRows(triangles.rows() - 1), doll.weights, joints),
                      Catch::Contains("open"));
}

TEST_CASE("symmetric remeshing of MakeHuman's body at demo size", "[slow]")
{
    if (data_folder().empty()) return;
    const MakeHuman source(data_folder() + "/makehuman");
    const ParametricSurface surface = source.evaluate({});
    const SymmetricRemesher remesher(surface.vertices, surface.triangles, source.weights(), surface.joint_positions);
    const RemeshedSkin skin = remesher.remesh(remesher.edge_length_for_prisms(6000), 0.25);
    CHECK(std::abs(skin.num_body_triangles() / 3000.0 - 1.0) < 0.03);
    CHECK(smallest_angle(skin, 0) > 20.0 * degree);
    // The source's toes lie in each other.
    CHECK(!self_intersections(surface.vertices, surface.triangles).empty());
    CHECK(self_intersections(skin.vertices.cast<float>().cast<double>(), skin.triangles, true).empty());
    CHECK(farthest_from(TriangleTree(surface.vertices, surface.triangles), skin.vertices) < 1e-9);
    check_mirror(skin, 0.002);  // the source is a little asymmetric
    check_borders(skin, surface.joint_positions, 8);
}
