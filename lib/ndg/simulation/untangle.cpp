// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/untangle.h"

#include "ndg/geometry/surface_pairs.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>

namespace ndg {

namespace {

/// Share of their distance to the bone wrap that crossed skin and its neighbourhood keep in each round.
constexpr double drawn_share = 0.8;
/// Rings of vertices about the crossed ones that follow, less from ring to ring.
constexpr int rings = 3;
constexpr double least_share = 0.03;
/// The same on the way out again.
constexpr double out_share = 0.93;
constexpr int max_rounds = 60;
/// Share of the gap below which skin all but touches skin.
constexpr double least_gap_share = 0.1;

/// Vertices of skin that crosses itself, or where there is none of skin that all but touches itself.
std::vector<int> met_vertices(const Points& skin, const Triangles& triangles, const SurfaceParts& parts, double gap)
{
    std::vector<int> met;
    for (const int t : triangles_of_pairs(crossing_triangles(skin, triangles))) {
        for (int a = 0; a < 3; ++a) met.push_back(triangles(t, a));
    }
    if (!met.empty()) return met;
    for (const SurfacePair& pair : parts.close_pairs(skin, least_gap_share * gap)) {
        met.insert(met.end(), pair.vertices.begin(), pair.vertices.end());
    }
    return met;
}

/// Per vertex of the wrap: 1 where it is met, falling to 0 beyond the rings.
Eigen::VectorXd spread(const std::vector<int>& met, const std::vector<std::vector<int>>& neighbours)
{
    const auto num_vertices = static_cast<int>(neighbours.size());
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(num_vertices);
    for (const int v : met) weights[v] = 1;
    for (int ring = 1; ring <= rings; ++ring) {
        const double weight = 1 - double(ring) / (rings + 1);
        const Eigen::VectorXd inner = weights;
        for (int v = 0; v < num_vertices; ++v) {
            for (const int other : neighbours[v]) {
                if (inner[other] > weight) weights[v] = std::max(weights[v], weight);
            }
        }
    }
    return weights;
}

}  // namespace

std::vector<std::pair<int, int>> untangle(Points& volume_vertices, const Template& body_template, double gap)
{
    const Triangles& triangles = body_template.wrap_triangles;
    const int num_wrap = body_template.num_wrap_vertices();
    const Points start = volume_vertices;
    std::vector<std::vector<int>> neighbours(num_wrap);
    for (const MeshEdge& edge : mesh_edges(triangles, num_wrap)) {
        neighbours[edge.v0].push_back(edge.v1);
        neighbours[edge.v1].push_back(edge.v0);
    }
    auto skin = volume_vertices.bottomRows(num_wrap);
    Eigen::VectorXd shares = Eigen::VectorXd::Ones(num_wrap);
    const auto place = [&](int v) {
        for (const int row : {num_wrap + v, 2 * num_wrap + v}) {
            volume_vertices.row(row) = start.row(v) + shares[v] * (start.row(row) - start.row(v));
        }
    };
    const SurfaceParts parts(triangles, num_wrap);
    Eigen::VectorXd evened = Eigen::VectorXd::Zero(num_wrap);
    for (int round = 0; round < max_rounds; ++round) {
        const std::vector<int> met = met_vertices(skin, triangles, parts, gap);
        if (met.empty()) break;
        const Eigen::VectorXd crossed = spread(met, neighbours);
        const Points before = skin;
        for (int v = 0; v < num_wrap; ++v) {
            if (!(crossed[v] > 0)) continue;
            if (shares[v] > least_share) {
                shares[v] = std::max(least_share, shares[v] * (1 - crossed[v] * (1 - drawn_share)));
                place(v);
            } else {
                Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
                for (const int other : neighbours[v]) mean += before.row(other) / double(neighbours[v].size());
                skin.row(v) += 0.5 * crossed[v] * (mean - before.row(v));
                volume_vertices.row(num_wrap + v) = 0.5 * (start.row(v) + skin.row(v));
                evened[v] = 1;
            }
        }
    }
    std::vector<std::pair<int, int>> crossings = crossing_triangles(skin, triangles);
    if (!crossings.empty()) return crossings;

    const auto thickened = [&]() -> Points { return skin + 0.5 * gap * vertex_normals(skin, triangles); };
    // Neighbours of what was crossed were drawn in too far, mostly; out again while nothing crosses.
    std::vector<char> open(num_wrap, 1);
    for (int round = 0; round < max_rounds; ++round) {
        const Eigen::VectorXd before = shares;
        int moved = 0;
        for (int v = 0; v < num_wrap; ++v) {
            if (!open[v] || evened[v] > 0 || shares[v] >= 1) continue;
            shares[v] = std::min(1.0, shares[v] / out_share);
            place(v);
            ++moved;
        }
        if (moved == 0) break;
        for (bool drawn = true; drawn;) {
            drawn = false;
            for (const int t : triangles_of_pairs(crossing_triangles(thickened(), triangles))) {
                for (int a = 0; a < 3; ++a) {
                    const int v = triangles(t, a);
                    if (shares[v] == before[v]) continue;
                    shares[v] = before[v];
                    open[v] = 0;
                    place(v);
                    drawn = true;
                }
            }
        }
    }
    return crossing_triangles(skin, triangles);
}

}  // namespace ndg
