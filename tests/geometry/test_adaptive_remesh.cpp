// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/geometry/adaptive_remesh.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/decimate.h"
#include "ndg/geometry/dynamic_mesh.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace ndg;

namespace {

TriangleMesh sphere_mesh(double radius, int levels)
{
    const test::Surface sphere = test::icosphere(radius, levels);
    return {sphere.vertices, sphere.triangles};
}

double centroid_height(const TriangleMesh& mesh, Eigen::Index triangle)
{
    double sum = 0.0;
    for (int corner = 0; corner < 3; ++corner) sum += mesh.vertices(mesh.triangles(triangle, corner), 1);
    return sum / 3.0;
}

}  // namespace

TEST_CASE("a mesh under random splits, flips and collapses stays closed")
{
    const TriangleMesh sphere = sphere_mesh(0.5, 2);
    std::vector<int> labels;
    for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) labels.push_back(centroid_height(sphere, t) > 0 ? 1 : 0);
    DynamicMesh mesh(sphere.vertices, sphere.triangles, labels);
    unsigned state = 1;
    int splits = 0, flips = 0, collapses = 0;
    for (int step = 0; step < 3000; ++step) {
        state = state * 1664525u + 1013904223u;  // Numerical Recipes
        const auto edges = mesh.edges();
        const auto [a, b] = edges[(state >> 8) % edges.size()];
        switch ((state >> 28) % 3) {
            case 0:
                mesh.split(a, b, 0.5 * (mesh.position(a) + mesh.position(b)));
                ++splits;
                break;
            case 1:
                if (!mesh.can_flip(a, b)) break;
                mesh.flip(a, b);
                ++flips;
                break;
            default:
                if (!mesh.can_collapse(a, b)) break;
                mesh.collapse(a, b);
                ++collapses;
        }
        if (step % 100 != 99) continue;
        Points vertices;
        Triangles triangles;
        std::vector<int> remaining;
        mesh.compact(vertices, triangles, remaining);
        const auto count = static_cast<int>(vertices.rows());
        for (const auto& edge : mesh_edges(triangles, count)) REQUIRE(edge.right_triangle >= 0);
        REQUIRE(vertices.rows() - triangles.rows() / 2 == 2);  // Euler's number of a sphere
        // The border between the labels stays one chain.
        std::vector<int> rows;
        for (std::size_t t = 0; t < remaining.size(); ++t)
            if (remaining[t] == 1) rows.push_back(static_cast<int>(t));
        REQUIRE(boundary_loops(triangles(rows, Eigen::all), count).size() == 1);
    }
    CHECK(splits > 100);
    CHECK(flips > 100);
    CHECK(collapses > 100);
}

TEST_CASE("adaptive remeshing of an open hemisphere with two regions")
{
    // The half x > 0 of a sphere, split at y = 0.1, finer towards the top.
    const TriangleMesh sphere = sphere_mesh(0.5, 4);
    TriangleMesh half;
    std::vector<int> labels, rows;
    for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
        double x = 0.0;
        for (int k = 0; k < 3; ++k) x += sphere.vertices(sphere.triangles(t, k), 0) / 3.0;
        if (x < 0.0) continue;
        rows.push_back(static_cast<int>(t));
        labels.push_back(centroid_height(sphere, t) > 0.1 ? 2 : 1);
    }
    std::vector<int> new_of_old(sphere.vertices.rows(), -1), kept;
    half.triangles = sphere.triangles(rows, Eigen::all);
    for (Eigen::Index t = 0; t < half.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) {
            int& number = new_of_old[half.triangles(t, k)];
            if (number < 0) {
                number = static_cast<int>(kept.size());
                kept.push_back(half.triangles(t, k));
            }
            half.triangles(t, k) = number;
        }
    half.vertices = sphere.vertices(kept, Eigen::all);
    RemeshField field;
    const auto wanted = [](double y) { return y > 0.0 ? 0.04 : 0.04 - 0.08 * y; };
    field.edge_length = half.vertices.col(1).unaryExpr(wanted);
    field.fixed.assign(kept.size(), 0);
    const LabelledMesh result = remesh_adaptively(half, labels, field);

    const TriangleTree tree(half.vertices, half.triangles);
    for (Eigen::Index v = 0; v < result.mesh.vertices.rows(); ++v)
        REQUIRE(tree.closest(result.mesh.vertices.row(v).transpose()).distance < 1e-9);
    for (Eigen::Index t = 0; t < result.mesh.triangles.rows(); ++t) {
        const auto corner = [&](int k) -> Eigen::Vector3d {
            return result.mesh.vertices.row(result.mesh.triangles(t, k));
        };
        REQUIRE(DynamicMesh::min_angle(corner(0), corner(1), corner(2)) > 25.0 * M_PI / 180.0);
    }
    double worst = 0.0, sum = 0.0;
    const auto edges = mesh_edges(result.mesh.triangles, static_cast<int>(result.mesh.vertices.rows()));
    for (const auto& edge : edges) {
        const Eigen::RowVector3d a = result.mesh.vertices.row(edge.v0), b = result.mesh.vertices.row(edge.v1);
        const double ratio = (b - a).norm() / wanted(0.5 * (a[1] + b[1]));
        worst = std::max(worst, ratio);
        sum += ratio;
    }
    CHECK(worst < 1.7);
    CHECK(sum / static_cast<double>(edges.size()) == Approx(1.0).margin(0.15));
    // One boundary, which runs round the sphere, and one border between the regions.
    const auto loops = boundary_loops(result.mesh.triangles, static_cast<int>(result.mesh.vertices.rows()));
    REQUIRE(loops.size() == 1);
    const auto length = [](const std::vector<int>& loop, const Points& points) {
        double total = 0.0;
        for (std::size_t i = 0; i < loop.size(); ++i)
            total += (points.row(loop[i]) - points.row(loop[(i + 1) % loop.size()])).norm();
        return total;
    };
    CHECK(length(loops[0], result.mesh.vertices) == Approx(M_PI).epsilon(0.03));  // a great circle

    // Fixed vertices stay with the edges between them.
    field.fixed.assign(kept.size(), 1);
    const LabelledMesh same = remesh_adaptively(half, labels, field);
    CHECK(same.mesh.vertices == half.vertices);
    CHECK(same.mesh.triangles == half.triangles);
    field.edge_length[3] = 0.0;
    CHECK_THROWS_AS(remesh_adaptively(half, labels, field), InputError);
    field.fixed.pop_back();
    CHECK_THROWS_AS(remesh_adaptively(half, labels, field), InputError);
}

TEST_CASE("no edge crosses an open surface from boundary to boundary")
{
    // A strip one edge wide, whose every edge across does so.
    constexpr int length = 20;
    const double side = 0.05;
    TriangleMesh strip;
    strip.vertices.resize(2 * (length + 1), 3);
    for (int i = 0; i <= length; ++i) {
        strip.vertices.row(2 * i) << side * i, 0.0, 0.0;
        strip.vertices.row(2 * i + 1) << side * i, side, 0.0;
    }
    strip.triangles.resize(2 * length, 3);
    for (int i = 0; i < length; ++i) {
        strip.triangles.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 3;
        strip.triangles.row(2 * i + 1) << 2 * i, 2 * i + 3, 2 * i + 1;
    }
    const RemeshField field{Eigen::VectorXd::Constant(strip.vertices.rows(), side),
                            std::vector<char>(static_cast<std::size_t>(strip.vertices.rows()), 0)};
    const std::vector<int> labels(2 * length, 0);
    const LabelledMesh result = remesh_adaptively(strip, labels, field);
    const auto edges = mesh_edges(result.mesh.triangles, static_cast<int>(result.mesh.vertices.rows()));
    std::vector<char> on_boundary(result.mesh.vertices.rows(), 0);
    for (const auto& edge : edges) {
        if (edge.right_triangle >= 0) continue;
        on_boundary[edge.v0] = on_boundary[edge.v1] = 1;
    }
    int inner = 0;
    for (const auto& edge : edges) {
        if (edge.right_triangle < 0) continue;
        ++inner;
        CHECK_FALSE((on_boundary[edge.v0] && on_boundary[edge.v1]));
    }
    CHECK(inner > 10);
}

TEST_CASE("decimation onto vertices of the input")
{
    const TriangleMesh sphere = sphere_mesh(0.5, 3);
    std::vector<int> labels;
    for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) labels.push_back(centroid_height(sphere, t) > 0 ? 1 : 0);
    const auto kept_before = std::count(labels.begin(), labels.end(), 0);
    const LabelledMesh result = decimate_labelled(sphere, labels, 150);
    CHECK(closed_surface_defect(result.mesh.vertices, result.mesh.triangles).empty());
    CHECK(self_intersections(result.mesh.vertices, result.mesh.triangles, true).empty());
    CHECK(std::count(result.triangle_labels.begin(), result.triangle_labels.end(), 0) == kept_before);
    const auto left = std::count(result.triangle_labels.begin(), result.triangle_labels.end(), 1);
    CHECK(left <= 150);
    CHECK(left >= 148);
    const auto is_input = [&](const Eigen::RowVector3d& point) {
        return (sphere.vertices.rowwise() - point).rowwise().squaredNorm().minCoeff() == 0.0;
    };
    for (Eigen::Index v = 0; v < result.mesh.vertices.rows(); ++v) REQUIRE(is_input(result.mesh.vertices.row(v)));
    CHECK(enclosed_volume(result.mesh.vertices, result.mesh.triangles) ==
          Approx(enclosed_volume(sphere.vertices, sphere.triangles)).epsilon(0.05));
    // Only what may go goes.
    std::vector<char> removable(sphere.vertices.rows(), 0);
    CHECK(decimate_labelled(sphere, labels, 10, removable).mesh.triangles == sphere.triangles);
    Eigen::Index top = 0;
    sphere.vertices.col(1).maxCoeff(&top);
    removable[top] = 1;
    CHECK(decimate_labelled(sphere, labels, 10, removable).mesh.vertices.rows() == sphere.vertices.rows() - 1);
}
