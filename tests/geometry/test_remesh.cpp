// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/remesh.h"
#include "ndg/geometry/triangle_mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

using namespace ndg;

namespace {

struct Quality {
    int triangles = 0;
    double min_angle = M_PI;
    double mean_edge = 0.0;
    double longest_edge = 0.0;
    double farthest = 0.0;  ///< of its vertices from the input surface
};

Quality measure(const RemeshResult& result, int label, const TriangleTree& input)
{
    Quality quality;
    for (Eigen::Index t = 0; t < result.mesh.triangles.rows(); ++t) {
        if (result.triangle_labels[static_cast<std::size_t>(t)] != label) continue;
        ++quality.triangles;
        for (int corner = 0; corner < 3; ++corner) {
            const Eigen::RowVector3d a = result.mesh.vertices.row(result.mesh.triangles(t, corner));
            const Eigen::RowVector3d b = result.mesh.vertices.row(result.mesh.triangles(t, (corner + 1) % 3));
            const Eigen::RowVector3d c = result.mesh.vertices.row(result.mesh.triangles(t, (corner + 2) % 3));
            quality.min_angle = std::min(quality.min_angle, std::acos((b - a).normalized().dot((c - a).normalized())));
            quality.mean_edge += (b - a).norm();
            quality.longest_edge = std::max(quality.longest_edge, (b - a).norm());
            quality.farthest = std::max(quality.farthest, input.closest(a.transpose()).distance);
        }
    }
    quality.mean_edge /= 3.0 * quality.triangles;
    return quality;
}

double border_length(const TriangleMesh& mesh, const std::vector<int>& labels, int& num_edges, double& longest)
{
    double length = 0.0;
    num_edges = 0;
    longest = 0.0;
    for (const auto& edge : mesh_edges(mesh.triangles, static_cast<int>(mesh.vertices.rows()))) {
        if (labels[static_cast<std::size_t>(edge.left_triangle)] ==
            labels[static_cast<std::size_t>(edge.right_triangle)]) {
            continue;
        }
        const double edge_length = (mesh.vertices.row(edge.v0) - mesh.vertices.row(edge.v1)).norm();
        length += edge_length;
        longest = std::max(longest, edge_length);
        ++num_edges;
    }
    return length;
}

double centroid_height(const TriangleMesh& mesh, Eigen::Index triangle)
{
    double sum = 0.0;
    for (int corner = 0; corner < 3; ++corner) sum += mesh.vertices(mesh.triangles(triangle, corner), 1);
    return sum / 3.0;
}

TriangleMesh sphere_mesh(double radius, int levels)
{
    const test::Surface sphere = test::icosphere(radius, levels);
    return {sphere.vertices, sphere.triangles};
}

/// Group `body` of the MakeHuman base mesh in metres, vertices in order of first use.
TriangleMesh read_makehuman_body(const std::string& path)
{
    std::ifstream file(path);
    std::vector<Eigen::RowVector3d> all;
    std::map<int, int> index_of;
    std::vector<Eigen::RowVector3d> used;
    std::vector<Eigen::RowVector3i> triangles;
    std::string line;
    std::string group;
    while (std::getline(file, line)) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            Eigen::RowVector3d point;
            words >> point[0] >> point[1] >> point[2];
            all.push_back(0.1 * point);
        } else if (word == "g") {
            words >> group;
        } else if (word == "f" && group == "body") {
            std::vector<int> polygon;
            while (words >> word) {
                const int original = std::stoi(word) - 1;
                const auto [entry, added] = index_of.emplace(original, static_cast<int>(used.size()));
                if (added) used.push_back(all[static_cast<std::size_t>(original)]);
                polygon.push_back(entry->second);
            }
            for (std::size_t i = 2; i < polygon.size(); ++i)
                triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
        }
    }
    TriangleMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
    for (std::size_t i = 0; i < used.size(); ++i) mesh.vertices.row(static_cast<Eigen::Index>(i)) = used[i];
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t i = 0; i < triangles.size(); ++i) mesh.triangles.row(static_cast<Eigen::Index>(i)) = triangles[i];
    return mesh;
}

}  // namespace

TEST_CASE("remesh: a sphere of three regions")
{
    const double radius = 0.5;
    const double target = 0.08;
    const TriangleMesh sphere = sphere_mesh(radius, 4);
    std::vector<int> labels;
    for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
        const double height = centroid_height(sphere, t);
        labels.push_back(height > 0.25 ? 0 : (height > -0.1 ? 1 : 2));
    }
    const auto unlabelled = std::count(labels.begin(), labels.end(), 0);
    const RemeshResult result = remesh_regions(sphere, labels, target, 0.4);

    CHECK(closed_surface_defect(result.mesh.vertices, result.mesh.triangles).empty());
    REQUIRE(static_cast<Eigen::Index>(result.triangle_labels.size()) == result.mesh.triangles.rows());
    CHECK(self_intersections(result.mesh.vertices, result.mesh.triangles).empty());
    const TriangleTree tree(sphere.vertices, sphere.triangles);
    for (const int label : {1, 2}) {
        const Quality quality = measure(result, label, tree);
        CHECK(quality.mean_edge > 0.75 * target);
        CHECK(quality.mean_edge < 1.25 * target);
        CHECK(quality.longest_edge < 1.7 * target);
        CHECK(quality.min_angle > 0.3);
        CHECK(quality.farthest < 1e-12);
    }
    const Quality rest = measure(result, 0, tree);
    CHECK(std::abs(rest.triangles - 0.4 * static_cast<double>(unlabelled)) < 0.05 * static_cast<double>(unlabelled));

    // The regions stay where they were and their borders remain chains of about the target length.
    for (Eigen::Index t = 0; t < result.mesh.triangles.rows(); ++t) {
        const double height = centroid_height(result.mesh, t);
        const int label = result.triangle_labels[static_cast<std::size_t>(t)];
        if (label == 0) CHECK(height > 0.25 - target);
        if (label == 1) CHECK((height < 0.25 + target && height > -0.1 - target));
        if (label == 2) CHECK(height < -0.1 + target);
    }
    int edges = 0;
    double longest = 0.0;
    const double length = border_length(result.mesh, result.triangle_labels, edges, longest);
    CHECK(longest < 1.5 * target);
    CHECK(length / edges > 0.5 * target);

    const RemeshResult again = remesh_regions(sphere, labels, target, 0.4);
    CHECK(again.mesh.vertices == result.mesh.vertices);
    CHECK(again.mesh.triangles == result.mesh.triangles);
    CHECK(again.triangle_labels == result.triangle_labels);
}

TEST_CASE("remesh: coarse input is refined, also along borders")
{
    const TriangleMesh sphere = sphere_mesh(0.5, 1);
    std::vector<int> labels;
    for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) labels.push_back(centroid_height(sphere, t) > 0 ? 1 : 2);
    const RemeshResult result = remesh_regions(sphere, labels, 0.08, 1.0);
    CHECK(closed_surface_defect(result.mesh.vertices, result.mesh.triangles).empty());
    const TriangleTree tree(sphere.vertices, sphere.triangles);
    CHECK(measure(result, 1, tree).longest_edge < 0.14);
    CHECK(measure(result, 1, tree).farthest < 1e-12);
    int edges = 0;
    double longest = 0.0;
    border_length(result.mesh, result.triangle_labels, edges, longest);
    CHECK(longest < 0.12);
}

TEST_CASE("remesh: unlabelled meshes and teeth")
{
    const TriangleMesh sphere = sphere_mesh(0.5, 2);
    const auto count = static_cast<std::size_t>(sphere.triangles.rows());
    // Without labels and at a keep ratio of one nothing changes.
    const RemeshResult same = remesh_regions(sphere, std::vector<int>(count, 0), 0.1, 1.0);
    CHECK(same.mesh.vertices == sphere.vertices);
    CHECK(same.mesh.triangles.rows() == sphere.triangles.rows());
    // A single triangle inside another region is no region.
    std::vector<int> labels(count, 1);
    labels[17] = 2;
    const RemeshResult result = remesh_regions(sphere, labels, 0.1, 1.0);
    CHECK(std::count(result.triangle_labels.begin(), result.triangle_labels.end(), 2) == 0);
}

TEST_CASE("remesh: bad input is named")
{
    const TriangleMesh sphere = sphere_mesh(0.5, 1);
    const std::vector<int> labels(static_cast<std::size_t>(sphere.triangles.rows()), 1);
    TriangleMesh open = sphere;
    open.triangles.conservativeResize(sphere.triangles.rows() - 1, 3);
    std::vector<int> fewer(labels.begin(), labels.end() - 1);
    CHECK_THROWS_AS(remesh_regions(open, fewer, 0.1, 1.0), InputError);
    CHECK_THROWS_AS(remesh_regions(sphere, fewer, 0.1, 1.0), InputError);
    CHECK_THROWS_AS(remesh_regions(sphere, labels, 0.0, 1.0), InputError);
    CHECK_THROWS_AS(remesh_regions(sphere, labels, std::nan(""), 1.0), InputError);
    CHECK_THROWS_AS(remesh_regions(sphere, labels, 0.1, 0.0), InputError);
    std::vector<int> negative = labels;
    negative[3] = -1;
    CHECK_THROWS_AS(remesh_regions(sphere, negative, 0.1, 1.0), InputError);
}

TEST_CASE("self-intersections are found and neighbours are none")
{
    const TriangleMesh sphere = sphere_mesh(1.0, 2);
    CHECK(self_intersections(sphere.vertices, sphere.triangles).empty());
    Points vertices(9, 3);
    vertices << 0, 0, 0, 2, 0, 0, 0, 2, 0,   // in the plane z = 0
        0.5, 0.5, -1, 0.5, 0.5, 1, 3, 3, 0,  // pierces it
        0.5, 0.5, 5, 0.5, 1.5, 5, 3, 3, 5;   // far above
    Triangles triangles(3, 3);
    triangles << 0, 1, 2, 3, 4, 5, 6, 7, 8;
    CHECK(self_intersections(vertices, triangles) == std::vector<std::pair<int, int>>{{0, 1}});
    // Triangles shrunk to segments: one pierces the first triangle, one misses it.
    vertices.row(5) << 0.5, 0.5, 0.0;
    CHECK(self_intersections(vertices, triangles) == std::vector<std::pair<int, int>>{{0, 1}});
    vertices.row(3) << 5, 5, -1;
    vertices.row(4) << 5, 5, 1;
    vertices.row(5) << 5, 5, 0;
    CHECK(self_intersections(vertices, triangles).empty());
    // Touching counts, sharing a vertex does not.
    vertices.row(3) << 1, 0, 0;
    vertices.row(4) << 1, -1, 1;
    vertices.row(5) << 1, -1, -1;
    CHECK(self_intersections(vertices, triangles).size() == 1);
    triangles.row(1) << 0, 4, 5;
    CHECK(self_intersections(vertices, triangles).empty());
}

TEST_CASE("remesh: a human body")
{
    if (test::data_folder().empty()) return;
    const TriangleMesh body = read_makehuman_body(test::data_folder() + "/makehuman/3dobjs/base.obj");
    REQUIRE(body.triangles.rows() == 26756);
    // Trunk and limbs 1; head, hands and feet 0.
    const double top = body.vertices.col(1).maxCoeff();
    const double bottom = body.vertices.col(1).minCoeff();
    const double reach = body.vertices.col(0).maxCoeff();
    std::vector<int> labels;
    for (Eigen::Index t = 0; t < body.triangles.rows(); ++t) {
        Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
        for (int corner = 0; corner < 3; ++corner) centre += body.vertices.row(body.triangles(t, corner)) / 3.0;
        const bool cut = centre[1] > top - 0.26 || std::abs(centre[0]) > reach - 0.19 || centre[1] < bottom + 0.08;
        labels.push_back(cut ? 0 : 1);
    }
    const RemeshResult result = remesh_regions(body, labels, 0.032, 0.3);
    CHECK(closed_surface_defect(result.mesh.vertices, result.mesh.triangles).empty());
    const Quality quality = measure(result, 1, TriangleTree(body.vertices, body.triangles));
    CHECK(quality.triangles > 2500);
    CHECK(quality.triangles < 4000);
    CHECK(quality.min_angle > 10.0 * M_PI / 180.0);
    CHECK(quality.mean_edge == Approx(0.032).epsilon(0.15));
    CHECK(quality.farthest < 1e-12);
    const double volume = enclosed_volume(body.vertices, body.triangles);
    CHECK(enclosed_volume(result.mesh.vertices, result.mesh.triangles) == Approx(volume).epsilon(0.02));
    // No fold: neighbouring triangles of the trunk and limbs never face each other.
    for (const auto& edge : mesh_edges(result.mesh.triangles, static_cast<int>(result.mesh.vertices.rows()))) {
        const auto labelled = [&](int triangle) {
            return result.triangle_labels[static_cast<std::size_t>(triangle)] > 0;
        };
        if (!labelled(edge.left_triangle) || !labelled(edge.right_triangle)) continue;
        const double angle =
            dihedral_angle(result.mesh.vertices.row(edge.v0), result.mesh.vertices.row(edge.v1),
                           result.mesh.vertices.row(edge.left_vertex), result.mesh.vertices.row(edge.right_vertex));
        REQUIRE(std::abs(angle) < 2.0);
    }
}
