// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/skeleton_projection.h"
#include "ndg/avatar/soft_tissue_layer.h"
#include "ndg/core/error.h"
#include "tube_body.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <map>
#include <set>

using namespace ndg;

namespace {

/// A star: a bone down to joint 1, from which two go on, one of them by another joint.
struct Star {
    Skeleton skeleton;
    Points positions = Points(5, 3);
    Star()
    {
        skeleton.joint_names = {"root", "middle", "left", "right", "far"};
        skeleton.parents = {-1, 0, 1, 1, 3};
        positions << 0, 1, 0, 0, 0, 0, 0.8, -0.2, 0, -0.5, -0.5, 0.1, -0.5, -1.2, 0.1;
    }
    SkeletonTree tree() const { return {skeleton, positions}; }
};

/// Places all over the tree.
std::vector<SkeletonPoint> places(const Star& star, int per_bone)
{
    std::vector<SkeletonPoint> list;
    for (int j = 1; j < 5; ++j) {
        const double length = (star.positions.row(j) - star.positions.row(star.skeleton.parents[j])).norm();
        for (int i = 0; i <= per_bone; ++i) list.push_back({j, length * i / per_bone});
    }
    return list;
}

struct TubeLayer {
    test::TubeBody scene;
    SoftRegion region;
    Points outer;
    explicit TubeLayer(int rings = 25, int segments = 12) : scene(rings, segments)
    {
        const StatisticalBody& body = scene.body;
        region = soft_region(body.vertices, body.triangles, body.soft_triangles);
        outer.resize(region.size(), 3);
        for (int v = 0; v < region.size(); ++v) outer.row(v) = body.vertices.row(region.skin_vertices[v]);
    }
    SoftTissueLayer layer(const LayerOptions& options) const
    {
        const StatisticalBody& body = scene.body;
        const SkeletonTree tree(body.skeleton, body.joint_positions(body.vertices), flesh_joints(region, body.weights));
        return soft_tissue_layer(outer, region, tree, options);
    }
};

}  // namespace

TEST_CASE("Distances on a skeleton run along its bones")
{
    const Star star;
    const SkeletonTree tree = star.tree();
    const double to_left = star.positions.row(2).norm(), to_right = star.positions.row(3).norm();
    CHECK(tree.distance({1, 0.25}, {1, 0.75}) == Approx(0.5));
    CHECK(tree.distance({1, 0.25}, {2, 0.3}) == Approx(0.75 + 0.3));
    CHECK(tree.distance({2, to_left}, {4, 0.1}) == Approx(to_left + to_right + 0.1));
    CHECK(tree.distance({4, 0.1}, {2, to_left}) == Approx(to_left + to_right + 0.1));
    CHECK(tree.distance({3, to_right}, {4, 0}) == Approx(0).margin(1e-12));
    const SkeletonPoint nearest = tree.nearest({0.1, 0.5, 0.3});
    CHECK(nearest.joint == 1);
    CHECK(nearest.along == Approx(0.5));
    CHECK((tree.position(nearest) - Eigen::Vector3d(0, 0.5, 0)).norm() < 1e-12);
    CHECK((tree.position(tree.nearest({5, -0.2, 0})) - Eigen::Vector3d(star.positions.row(2))).norm() < 1e-12);
    // Only the bones of joints in the flesh are near, but ways lead over all.
    const SkeletonTree partly(star.skeleton, star.positions, {false, true, false, true, false});
    CHECK(partly.nearest({0.1, 0.5, 0.3}).joint == 2);
    CHECK(partly.distance({1, 0.25}, {2, 0.3}) == Approx(0.75 + 0.3));
    CHECK_THROWS_AS(SkeletonTree(star.skeleton, star.positions, {false, false, true, false, true}), InputError);
    Skeleton lone;
    lone.joint_names = {"root"};
    lone.parents = {-1};
    CHECK_THROWS_AS(SkeletonTree(lone, star.positions.topRows(1)), InputError);
}

TEST_CASE("The mean on a skeleton is the place of least squared distances, from wherever it is looked for")
{
    const Star star;
    const SkeletonTree tree = star.tree();
    const std::vector<SkeletonPoint> everywhere = places(star, 400), some = places(star, 3);
    for (std::uint64_t trial = 0; trial < 40; ++trial) {
        Random random(5, "mean", trial);
        std::vector<SkeletonPoint> points;
        std::vector<double> weights;
        for (int i = 0; i < 5; ++i) {
            points.push_back(everywhere[random.below(everywhere.size())]);
            weights.push_back(random.uniform(0.1, 2.0));
        }
        const auto energy = [&](const SkeletonPoint& place) {
            double sum = 0;
            for (std::size_t i = 0; i < points.size(); ++i)
                sum += weights[i] * std::pow(tree.distance(place, points[i]), 2);
            return sum;
        };
        double least = std::numeric_limits<double>::max();
        for (const SkeletonPoint& place : everywhere) least = std::min(least, energy(place));
        for (const SkeletonPoint& start : some) {
            const double found = energy(tree.mean(points, weights, start));
            CHECK(found <= least + 1e-12);
            CHECK(found > least - 1e-3);
        }
    }
}

TEST_CASE("Projections of neighbours become neighbours on the skeleton")
{
    // A sheet that a fork of bones lies below: nearest bones jump from one branch to the other in its middle.
    Star star;
    star.positions << 0, 1, 0, 0, 0.6, 0, 0.5, -1, 0, -0.5, -1, 0, -0.5, -1.5, 0;
    const SkeletonTree tree = star.tree();
    constexpr int size = 21;
    Points vertices(size * size, 3);
    Triangles triangles(2 * (size - 1) * (size - 1), 3);
    Eigen::Index row = 0;
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < size; ++j) {
            const int a = i * size + j;
            vertices.row(a) << 0.05 * (j - size / 2), -0.9 + 0.05 * i, 0.2;
            if (i + 1 == size || j + 1 == size) continue;
            triangles.row(row++) << a, a + 1, a + size;
            triangles.row(row++) << a + 1, a + size + 1, a + size;
        }
    const auto largest_stretch = [&](double smoothing_length) {
        const auto projections = project_to_skeleton(tree, vertices, triangles, {smoothing_length});
        double largest = 0;
        for (Eigen::Index t = 0; t < triangles.rows(); ++t)
            for (int c = 0; c < 3; ++c) {
                const int a = triangles(t, c), b = triangles(t, (c + 1) % 3);
                largest = std::max(largest, tree.distance(projections[a], projections[b]) /
                                                (vertices.row(a) - vertices.row(b)).norm());
            }
        return largest;
    };
    CHECK(largest_stretch(0) > 20);
    CHECK(largest_stretch(0.5) < 8);
    CHECK(largest_stretch(2.0) < 3);
    // Nothing moves where nearest places change no faster than the sheet.
    const auto nearest = project_to_skeleton(tree, vertices, triangles, {0});
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        CHECK(tree.distance(nearest[v], tree.nearest(vertices.row(v).transpose())) == 0);
}

TEST_CASE("The region of soft tissue ends at rims and is left out where it touches itself")
{
    const TubeLayer tube(9, 6);
    CHECK(tube.region.size() == 54);
    CHECK(tube.region.rim.size() == 12);
    CHECK(tube.region.triangles.rows() == 96);
    for (int v = 0; v < 54; ++v) {
        const double y = tube.outer(v, 1), length = tube.outer.col(1).maxCoeff();
        CHECK(tube.region.rim_distances[v] == Approx(std::min(y, length - y)).margin(1e-9));
    }
    const StatisticalBody& body = tube.scene.body;
    std::vector<int> flags = body.soft_triangles;
    SECTION("all of a closed skin has no rim")
    {
        flags.assign(flags.size(), 1);
        CHECK_THROWS_WITH(soft_region(body.vertices, body.triangles, flags), Catch::Contains("somewhere"));
        flags.assign(flags.size(), 0);
        CHECK_THROWS_WITH(soft_region(body.vertices, body.triangles, flags), Catch::Contains("no triangle"));
    }
    SECTION("two triangles that touch at a vertex go")
    {
        // Leaves everything out around one vertex but two opposite triangles.
        std::vector<int> around;
        const int centre = 4 * 6 + 2;
        for (Eigen::Index t = 0; t < body.triangles.rows(); ++t)
            if ((body.triangles.row(t).array() == centre).any()) around.push_back(int(t));
        REQUIRE(around.size() == 6);
        const auto share_edge = [&](int s, int t) {
            int common = 0;
            for (int a = 0; a < 3; ++a) common += (body.triangles.row(t).array() == body.triangles(s, a)).any();
            return common == 2;
        };
        int other = -1;
        for (const int t : around)
            if (t != around[0] && !share_edge(around[0], t)) other = t;
        REQUIRE(other >= 0);
        for (const int t : around) flags[t] = t == around[0] || t == other;
        const SoftRegion region = soft_region(body.vertices, body.triangles, flags);
        CHECK(region.region_of_skin[centre] == -1);
        Points outer(region.size(), 3);
        for (int v = 0; v < region.size(); ++v) outer.row(v) = body.vertices.row(region.skin_vertices[v]);
        const Points inner = (outer.array().rowwise() * Eigen::Array<double, 1, 3>(0.8, 1, 0.8)).matrix();
        const TriangleMesh surface = layer_surface(region, outer, inner);
        CHECK(closed_surface_defect(surface.vertices, surface.triangles).empty());
        CHECK(region.triangles.rows() == 90);
    }
    SECTION("crumbs go")
    {
        const TubeLayer fine;
        const StatisticalBody& skin = fine.scene.body;
        std::vector<int> without_ring = skin.soft_triangles;
        const Eigen::RowVector3i island = skin.triangles.row(200);
        for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
            for (int c = 0; c < 3; ++c)
                if (t != 200 && (skin.triangles.row(t).array() == island[c]).any()) without_ring[t] = 0;
        const SoftRegion region = soft_region(skin.vertices, skin.triangles, without_ring);
        for (int c = 0; c < 3; ++c) CHECK(region.region_of_skin[island[c]] == -1);
        CHECK(region.size() == fine.region.size() - 3);
        CHECK(region.rim.size() > fine.region.rim.size());
    }
    SECTION("joints of extremities")
    {
        const int forearm = body.skeleton.joint("left_forearm");
        const std::vector<int> soft =
            soft_triangles_without(body.triangles, RowMatrix(body.weights), body.skeleton.parents, {forearm});
        for (Eigen::Index t = 0; t < body.triangles.rows(); ++t) {
            double y = 0;
            for (int c = 0; c < 3; ++c) y += body.vertices(body.triangles(t, c), 1) / 3;
            if (std::abs(y - 0.5) > 0.1) CHECK(soft[t] == (y < 0.5));
        }
    }
}

TEST_CASE("The layer's surface is closed and outward, and as thick as it says")
{
    const TubeLayer tube;
    LayerOptions options;
    const SoftTissueLayer layer = tube.layer(options);
    for (int v = 0; v < tube.region.size(); ++v) {
        const double low = layer.min_thickness[v], high = layer.max_thickness[v], rim = tube.region.rim_distances[v];
        CHECK(low <= high);
        CHECK(layer.inward.row(v).norm() == Approx(1));
        if (rim == 0) {
            CHECK(low == Approx(options.rim_thickness));
            CHECK(high == Approx(options.rim_thickness));
        }
        if (rim > options.rim_fade) CHECK(low == Approx(options.min_thickness));
        // The axis is 8 cm away, in the mean body a little more.
        if (rim > 0.2 && tube.outer(v, 1) < 0.6)
            CHECK(high == Approx(tube.outer.row(v).head<3>().cwiseProduct(Eigen::RowVector3d(1, 0, 1)).norm() -
                                 options.bone_radius)
                              .margin(0.01));
    }
    const auto slopes = [&](const std::vector<double>& thickness) {
        double steepest = 0;
        for (Eigen::Index t = 0; t < tube.region.triangles.rows(); ++t)
            for (int c = 0; c < 3; ++c) {
                const int a = tube.region.triangles(t, c), b = tube.region.triangles(t, (c + 1) % 3);
                steepest = std::max(
                    steepest, std::abs(thickness[a] - thickness[b]) / (tube.outer.row(a) - tube.outer.row(b)).norm());
            }
        return steepest;
    };
    CHECK(slopes(layer.max_thickness) <= options.max_slope + 1e-9);
    for (const auto* thickness : {&layer.min_thickness, &layer.max_thickness}) {
        const Points inner = inner_surface(tube.outer, layer.inward, *thickness);
        const TriangleMesh surface = layer_surface(tube.region, tube.outer, inner);
        CHECK(closed_surface_defect(surface.vertices, surface.triangles).empty());
        CHECK(folded_triangles(tube.region, tube.outer, layer.inward, *thickness).empty());
        CHECK(((inner - tube.outer).rowwise().norm() -
               Eigen::Map<const Eigen::VectorXd>(thickness->data(), tube.region.size()))
                  .cwiseAbs()
                  .maxCoeff() < 1e-12);
    }
}

TEST_CASE("A thickness that folds the inner surface is found, and lowered to one that does not")
{
    const TubeLayer tube;
    const SoftTissueLayer layer = tube.layer({});
    // Through the axis and out on the other side.
    std::vector<double> thickness = layer.max_thickness;
    for (int v = 0; v < tube.region.size(); ++v)
        if (tube.region.rim_distances[v] > 0.3) thickness[v] = 0.12;
    CHECK(!folded_triangles(tube.region, tube.outer, layer.inward, thickness).empty());
    const int lowered = unfold_thickness(tube.region, tube.outer, layer.inward, layer.min_thickness, 1.0, thickness);
    CHECK(lowered > 0);
    CHECK(folded_triangles(tube.region, tube.outer, layer.inward, thickness).empty());
    for (int v = 0; v < tube.region.size(); ++v) CHECK(thickness[v] >= layer.min_thickness[v]);

    std::vector<double> too_thick(thickness.size(), 0.2);
    const std::vector<double> least = too_thick;
    CHECK_THROWS_WITH(unfold_thickness(tube.region, tube.outer, layer.inward, least, 1.0, too_thick),
                      Catch::Contains("folds over"));
    TubeLayer crossed;
    for (int v = 0; v < crossed.region.size(); ++v)
        if (std::abs(crossed.outer(v, 1) - 0.5) < 0.1) crossed.outer(v, 0) *= -0.5;
    CHECK_THROWS_WITH(crossed.layer({}), Catch::Contains("crosses itself"));
    LayerOptions options;
    options.rim_thickness = 0.01;
    CHECK_THROWS_WITH(tube.layer(options), Catch::Contains("rims"));
    options.rim_thickness = -1;
    CHECK_THROWS_AS(tube.layer(options), InputError);
}
