// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/split_edges.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace ndg {
namespace {

constexpr int max_rounds = 12;

double squared_edge(const RowMatrix& attributes, int a, int b)
{
    return (attributes.row(a).head<3>() - attributes.row(b).head<3>()).squaredNorm();
}

/// Splits every edge that the rule names once, at its middle; triangles into two, three or four. Returns whether any.
bool split_round(RowMatrix& attributes, Triangles& triangles, const SplitsEdge& splits)
{
    std::map<std::pair<int, int>, int> middles;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const int a = triangles(t, k), b = triangles(t, (k + 1) % 3);
            if (splits(attributes.row(a).head<3>().transpose(), attributes.row(b).head<3>().transpose()))
                middles.emplace(std::minmax(a, b), -1);
        }
    }
    if (middles.empty()) return false;
    Eigen::Index next = attributes.rows();
    attributes.conservativeResize(next + static_cast<Eigen::Index>(middles.size()), Eigen::NoChange);
    for (auto& [edge, middle] : middles) {
        attributes.row(next) = 0.5 * (attributes.row(edge.first) + attributes.row(edge.second));
        middle = static_cast<int>(next++);
    }
    std::vector<std::array<int, 3>> split;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<int, 3> corner{}, middle{};
        int count = 0;
        for (int k = 0; k < 3; ++k) {
            const auto i = static_cast<std::size_t>(k);
            corner[i] = triangles(t, k);
            const auto found = middles.find(std::minmax(triangles(t, k), triangles(t, (k + 1) % 3)));
            middle[i] = found == middles.end() ? -1 : found->second;
            count += middle[i] >= 0;
        }
        // Turned so that edge 0 is split (and edge 1, if two are).
        while (count > 0 && (count == 1 ? middle[0] < 0 : count == 2 && middle[2] >= 0)) {
            std::rotate(corner.begin(), corner.begin() + 1, corner.end());
            std::rotate(middle.begin(), middle.begin() + 1, middle.end());
        }
        if (count == 0) {
            split.push_back(corner);
        } else if (count == 1) {
            split.push_back({corner[0], middle[0], corner[2]});
            split.push_back({middle[0], corner[1], corner[2]});
        } else if (count == 2) {
            split.push_back({middle[0], corner[1], middle[1]});
            // The shorter diagonal of the quadrangle that is left.
            if (squared_edge(attributes, corner[0], middle[1]) < squared_edge(attributes, middle[0], corner[2])) {
                split.push_back({corner[0], middle[0], middle[1]});
                split.push_back({corner[0], middle[1], corner[2]});
            } else {
                split.push_back({corner[0], middle[0], corner[2]});
                split.push_back({middle[0], middle[1], corner[2]});
            }
        } else {
            for (std::size_t k = 0; k < 3; ++k) split.push_back({corner[k], middle[k], middle[(k + 2) % 3]});
            split.push_back(middle);
        }
    }
    triangles.resize(static_cast<Eigen::Index>(split.size()), 3);
    for (std::size_t t = 0; t < split.size(); ++t) {
        triangles.row(static_cast<Eigen::Index>(t)) << split[t][0], split[t][1], split[t][2];
    }
    return true;
}

}  // namespace

void split_long_edges(RowMatrix& attributes, Triangles& triangles, double length)
{
    split_edges(attributes, triangles, [length](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        return (a - b).squaredNorm() > length * length;
    });
}

void split_edges(RowMatrix& attributes, Triangles& triangles, const SplitsEdge& splits)
{
    for (int round = 0; round < max_rounds && split_round(attributes, triangles, splits); ++round) {
    }
}

}  // namespace ndg
