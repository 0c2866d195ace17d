// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/soft_region.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>

namespace ndg {

namespace {

/// Pieces of fewer triangles, as a share of all, are left out.
constexpr double least_piece = 0.01;

/// Directed edges of which the opposite one belongs to no triangle kept.
std::vector<std::array<int, 2>> open_edges(const Eigen::Ref<const Triangles>& triangles, const std::vector<bool>& kept)
{
    std::set<std::array<int, 2>> edges;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        if (!kept[t]) continue;
        for (int c = 0; c < 3; ++c) {
            const bool is_new = edges.insert({triangles(t, c), triangles(t, (c + 1) % 3)}).second;
            require_input(is_new,
                          "the skin's triangles with soft tissue are no oriented surface: triangle {} has an "
                          "edge from vertex {} to {}, as another one",
                          t, triangles(t, c), triangles(t, (c + 1) % 3));
        }
    }
    std::vector<std::array<int, 2>> open;
    for (const auto& edge : edges)
        if (edges.count({edge[1], edge[0]}) == 0) open.push_back(edge);
    return open;
}

/// Vertices at which the kept triangles are not one fan.
std::vector<bool> pinched_vertices(const Eigen::Ref<const Triangles>& triangles, const std::vector<bool>& kept,
                                   Eigen::Index num_vertices)
{
    // Around one vertex, triangles that share an edge at it are one piece.
    std::vector<std::vector<std::array<int, 2>>> opposite(num_vertices);  // the edge opposite to the vertex
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        if (!kept[t]) continue;
        for (int c = 0; c < 3; ++c)
            opposite[triangles(t, c)].push_back({triangles(t, (c + 1) % 3), triangles(t, (c + 2) % 3)});
    }
    std::vector<bool> pinched(num_vertices, false);
    for (Eigen::Index v = 0; v < num_vertices; ++v) {
        if (opposite[v].empty()) continue;
        std::map<int, int> next;
        std::set<int> ends;
        for (const auto& edge : opposite[v]) {
            next[edge[0]] = edge[1];
            ends.insert(edge[1]);
        }
        // A fan begins where no edge ends, or is a ring.
        int begin = opposite[v].front()[0];
        for (const auto& [from, to] : next)
            if (ends.count(from) == 0) begin = from;
        std::size_t walked = 0;
        for (auto step = next.find(begin); step != next.end() && walked < opposite[v].size();
             step = next.find(step->second))
            ++walked;
        pinched[v] = walked != opposite[v].size();
    }
    return pinched;
}

/// Leaves out pieces of few triangles, such as weights leave at the border of hands and feet.
void drop_crumbs(const Eigen::Ref<const Triangles>& triangles, std::vector<bool>& kept)
{
    std::map<std::array<int, 2>, int> left_of;  // triangle at each directed edge
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        if (kept[t])
            for (int c = 0; c < 3; ++c) left_of[{triangles(t, c), triangles(t, (c + 1) % 3)}] = int(t);
    std::vector<bool> seen(kept.size(), false);
    std::vector<std::vector<int>> pieces;
    std::size_t num_kept = 0;
    for (Eigen::Index first = 0; first < triangles.rows(); ++first) {
        if (!kept[first] || seen[first]) continue;
        std::vector<int> piece = {int(first)};
        seen[first] = true;
        for (std::size_t i = 0; i < piece.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                const int t = piece[i];
                const auto beside = left_of.find({triangles(t, (c + 1) % 3), triangles(t, c)});
                if (beside == left_of.end() || seen[beside->second]) continue;
                seen[beside->second] = true;
                piece.push_back(beside->second);
            }
        num_kept += piece.size();
        pieces.push_back(std::move(piece));
    }
    for (const std::vector<int>& piece : pieces)
        if (double(piece.size()) < least_piece * double(num_kept))
            for (const int t : piece) kept[t] = false;
}

std::vector<double> distances_from(const std::vector<int>& sources, const Points& vertices, const Triangles& triangles)
{
    const std::vector<std::vector<int>> neighbours = vertex_neighbours(triangles, int(vertices.rows()));
    std::vector<double> distances(neighbours.size(), std::numeric_limits<double>::infinity());
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const int v : sources) {
        distances[v] = 0;
        queue.emplace(0.0, v);
    }
    while (!queue.empty()) {
        const auto [distance, v] = queue.top();
        queue.pop();
        if (distance > distances[v]) continue;
        for (const int other : neighbours[v]) {
            const double further = distance + (vertices.row(v) - vertices.row(other)).norm();
            if (further >= distances[other]) continue;
            distances[other] = further;
            queue.emplace(further, other);
        }
    }
    return distances;
}

}  // namespace

SoftRegion soft_region(const Eigen::Ref<const Points>& skin_vertices, const Eigen::Ref<const Triangles>& skin_triangles,
                       const std::vector<int>& soft_triangles)
{
    require(Eigen::Index(soft_triangles.size()) == skin_triangles.rows(), "{} flags were given for {} triangles",
            soft_triangles.size(), skin_triangles.rows());
    const Eigen::Index num_skin = skin_vertices.rows();
    std::vector<bool> kept(soft_triangles.size());
    for (std::size_t t = 0; t < kept.size(); ++t) kept[t] = soft_triangles[t] != 0;
    for (bool changed = true; changed;) {
        changed = false;
        const std::vector<bool> pinched = pinched_vertices(skin_triangles, kept, num_skin);
        for (Eigen::Index t = 0; t < skin_triangles.rows(); ++t) {
            const auto corners = skin_triangles.row(t);
            if (!kept[t] || !(pinched[corners[0]] || pinched[corners[1]] || pinched[corners[2]])) continue;
            kept[t] = false;
            changed = true;
        }
    }

    drop_crumbs(skin_triangles, kept);

    SoftRegion region;
    region.region_of_skin.assign(num_skin, -1);
    std::vector<bool> used(num_skin, false);
    Eigen::Index num_triangles = 0;
    for (Eigen::Index t = 0; t < skin_triangles.rows(); ++t) {
        if (!kept[t]) continue;
        ++num_triangles;
        for (int c = 0; c < 3; ++c) used[skin_triangles(t, c)] = true;
    }
    require_input(num_triangles > 0, "no triangle of the skin has soft tissue below it");
    for (Eigen::Index v = 0; v < num_skin; ++v) {
        if (!used[v]) continue;
        region.region_of_skin[v] = region.size();
        region.skin_vertices.push_back(int(v));
    }
    region.triangles.resize(num_triangles, 3);
    Eigen::Index row = 0;
    for (Eigen::Index t = 0; t < skin_triangles.rows(); ++t) {
        if (!kept[t]) continue;
        for (int c = 0; c < 3; ++c) region.triangles(row, c) = region.region_of_skin[skin_triangles(t, c)];
        ++row;
    }

    std::set<int> rim;
    for (const auto& edge : open_edges(region.triangles, std::vector<bool>(num_triangles, true))) rim.insert(edge[0]);
    region.rim.assign(rim.begin(), rim.end());
    region.outer.assign(region.size(), -1);
    int next = region.size();
    for (const int v : region.rim) region.outer[v] = next++;
    for (int& outer : region.outer)
        if (outer < 0) outer = next++;

    Points vertices(region.size(), 3);
    for (int v = 0; v < region.size(); ++v) vertices.row(v) = skin_vertices.row(region.skin_vertices[v]);
    region.rim_distances = distances_from(region.rim, vertices, region.triangles);
    for (int v = 0; v < region.size(); ++v)
        require_input(std::isfinite(region.rim_distances[v]),
                      "the skin around vertex {} has soft tissue everywhere: somewhere (at head, hands and feet) it "
                      "must end",
                      region.skin_vertices[v]);
    return region;
}

std::vector<int> soft_triangles_without(const Eigen::Ref<const Triangles>& skin_triangles,
                                        const Eigen::Ref<const RowMatrix>& weights, const std::vector<int>& parents,
                                        const std::vector<int>& joints)
{
    std::vector<bool> left_out(parents.size(), false);
    for (const int joint : joints) {
        require(joint >= 0 && joint < int(parents.size()), "joint {} of {} was to be left out", joint, parents.size());
        left_out[joint] = true;
    }
    for (std::size_t j = 1; j < parents.size(); ++j) left_out[j] = left_out[j] || left_out[parents[j]];
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(weights.rows());
    for (std::size_t j = 0; j < parents.size(); ++j)
        if (left_out[j]) moved += weights.col(Eigen::Index(j));
    std::vector<int> soft(skin_triangles.rows());
    for (Eigen::Index t = 0; t < skin_triangles.rows(); ++t) {
        const auto corners = skin_triangles.row(t);
        soft[t] = (moved[corners[0]] + moved[corners[1]] + moved[corners[2]]) / 3 < 0.5;
    }
    return soft;
}

Points inner_surface(const Eigen::Ref<const Points>& outer, const Eigen::Ref<const Points>& inward,
                     const std::vector<double>& thickness)
{
    require(inward.rows() == outer.rows() && Eigen::Index(thickness.size()) == outer.rows(),
            "{} directions and {} thicknesses were given for {} vertices", inward.rows(), thickness.size(),
            outer.rows());
    Points inner = outer;
    for (Eigen::Index v = 0; v < outer.rows(); ++v) inner.row(v) += thickness[v] * inward.row(v);
    return inner;
}

TriangleMesh layer_surface(const SoftRegion& region, const Eigen::Ref<const Points>& outer,
                           const Eigen::Ref<const Points>& inner)
{
    const int w = region.size();
    require(outer.rows() == w && inner.rows() == w, "{} outer and {} inner vertices were given for a region of {}",
            outer.rows(), inner.rows(), w);
    TriangleMesh surface;
    surface.vertices.resize(2 * w, 3);
    surface.vertices.topRows(w) = inner;
    for (int v = 0; v < w; ++v) surface.vertices.row(region.outer[v]) = outer.row(v);

    const Eigen::Index count = region.triangles.rows();
    const auto open = open_edges(region.triangles, std::vector<bool>(count, true));
    surface.triangles.resize(2 * count + 2 * Eigen::Index(open.size()), 3);
    for (Eigen::Index t = 0; t < count; ++t) {
        const auto corners = region.triangles.row(t);
        surface.triangles.row(t) << region.outer[corners[0]], region.outer[corners[1]], region.outer[corners[2]];
        surface.triangles.row(count + t) << corners[0], corners[2], corners[1];
    }
    Eigen::Index row = 2 * count;
    for (const auto& [a, b] : open) {
        surface.triangles.row(row++) << region.outer[b], region.outer[a], a;
        surface.triangles.row(row++) << region.outer[b], a, b;
    }
    return surface;
}

}  // namespace ndg
