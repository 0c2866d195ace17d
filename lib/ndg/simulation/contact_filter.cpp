// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/contact_filter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>
#include <utility>

namespace ndg {

namespace {

/// Where vertices at the end of their way shorten the step by more than this, a new round begins.
constexpr double least_filtered_step = 0.2;
/// Pairs that would pass through each other are held back by themselves in so many passes, all vertices in the last.
constexpr int filter_passes = 4;

}  // namespace

ContactFilter::ContactFilter(const Points& start, const Eigen::VectorXd& radii, const std::vector<SurfacePair>& pairs,
                             double least_distance)
    : start_(start),
      radii_(radii),
      pairs_(pairs),
      least_distance_(least_distance),
      squared_radii_(radii.cwiseAbs2()),
      begin_(start.rows() + 1, 0)
{
    for (const SurfacePair& pair : pairs) {
        for (const int v : pair.vertices) ++begin_[v + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    pairs_at_.resize(4 * pairs.size());
    std::vector<int> end(begin_.begin(), begin_.end() - 1);
    for (int p = 0; p < int(pairs.size()); ++p) {
        for (const int v : pairs[p].vertices) pairs_at_[end[v]++] = p;
    }
}

void ContactFilter::keep_out(const std::vector<char>& is_element, double contact_distance)
{
    is_element_ = &is_element;
    contact_distance_ = contact_distance;
}

bool ContactFilter::operator()(const Points& from, Points& to, bool by_vertex) const
{
    std::vector<int> moving, concerned;
    double wanted = 0, left = 0, least_in_ball = 1;
    for (int v = 0; v < from.rows(); ++v) {
        const Eigen::RowVector3d move = to.row(v) - from.row(v);
        const double length = move.norm();
        if (length == 0) continue;
        const double share = share_in_ball(v, from.row(v) - start_.row(v), move);
        least_in_ball = std::min(least_in_ball, share);
        if (by_vertex) to.row(v) = from.row(v) + share * move;
        wanted += std::min(length, radii_[v]);
        left += share * length;
        moving.push_back(v);
        concerned.insert(concerned.end(), pairs_at_.begin() + begin_[v], pairs_at_.begin() + begin_[v + 1]);
    }
    if (left < least_filtered_step * wanted) return false;
    const auto draw_back = [&](double share) {
        for (const int v : moving) to.row(v) = from.row(v) + share * (to.row(v) - from.row(v));
    };
    if (!by_vertex) draw_back(least_in_ball);
    std::sort(concerned.begin(), concerned.end());
    concerned.erase(std::unique(concerned.begin(), concerned.end()), concerned.end());
    const auto outside = [&](int p) { return is_element_ != nullptr && (*is_element_)[p] == 0; };
    for (const int p : concerned) {
        if (!outside(p)) continue;
        const PairDistance distance(pairs_[p].kind, pair_corners(from, pairs_[p].vertices));
        if (distance.squared() < contact_distance_ * contact_distance_) return false;
    }
    std::vector<std::pair<int, double>> shares;
    for (int pass = by_vertex ? 0 : filter_passes; pass <= filter_passes; ++pass) {
        double least = 1;
        shares.clear();
        for (const int p : concerned) {
            const auto& vertices = pairs_[p].vertices;
            const double share =
                collision_free_share(pairs_[p].kind, pair_corners(from, vertices), pair_corners(to, vertices),
                                     outside(p) ? contact_distance_ : least_distance_);
            if (share == 1) continue;
            least = std::min(least, share);
            for (const int v : vertices) shares.emplace_back(v, share);
        }
        if (shares.empty()) return true;
        if (pass == filter_passes) {
            draw_back(least);
        } else {
            std::sort(shares.begin(), shares.end());  // a vertex's smallest first
            int last = -1;
            for (const auto& [v, share] : shares) {
                if (v != last) to.row(v) = from.row(v) + share * (to.row(v) - from.row(v));
                last = v;
            }
        }
    }
    return true;
}

/// Largest share up to one with |offset + share move| <= radius.
double ContactFilter::share_in_ball(int vertex, const Eigen::RowVector3d& offset, const Eigen::RowVector3d& move) const
{
    const double along = offset.dot(move), length = move.squaredNorm();
    const double room = std::max(0.0, squared_radii_[vertex] - offset.squaredNorm());
    if (length + 2 * along <= room) return 1;
    return (std::sqrt(along * along + length * room) - along) / length;
}

std::vector<SurfacePair> near_pairs(const std::vector<SurfacePair>& pairs, const Points& vertices, double reach)
{
    std::vector<SurfacePair> near;
    std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(near), [&](const SurfacePair& pair) {
        return PairDistance(pair.kind, pair_corners(vertices, pair.vertices)).squared() < reach * reach;
    });
    return near;
}

void remove_crossed(std::vector<SurfacePair>& pairs, const Triangles& triangles,
                    const std::vector<std::pair<int, int>>& crossings)
{
    if (crossings.empty()) return;
    std::set<std::pair<int, int>> left;  // vertices of triangles that cross each other
    for (const auto& [s, t] : crossings) {
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) left.insert(std::minmax(triangles(s, a), triangles(t, b)));
    }
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const SurfacePair& pair) {
                                   const int first = pair.kind == PairKind::point_triangle ? 1 : 2;
                                   for (int a = 0; a < first; ++a)
                                       for (int b = first; b < 4; ++b)
                                           if (!left.count(std::minmax(pair.vertices[a], pair.vertices[b])))
                                               return false;
                                   return true;
                               }),
                pairs.end());
}

}  // namespace ndg
