// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/girths.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

namespace ndg {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    return a[0] * b[1] - a[1] * b[0];
}

/// Counter-clockwise (Andrew's monotone chain).
Polygon convex_hull(Polygon points)
{
    std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]);
    });
    if (points.size() < 3) return points;
    Polygon hull;
    const auto add_chain = [&](auto begin, auto end, std::size_t keep) {
        for (auto it = begin; it != end; ++it) {
            while (hull.size() > keep && cross(hull.back() - hull[hull.size() - 2], *it - hull.back()) <= 0.0)
                hull.pop_back();
            hull.push_back(*it);
        }
    };
    add_chain(points.begin(), points.end(), 1);
    const std::size_t lower = hull.size();
    add_chain(points.rbegin() + 1, points.rend(), lower);
    hull.pop_back();
    return hull;
}

double perimeter(const Polygon& polygon)
{
    double length = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) length += (polygon[(i + 1) % polygon.size()] - polygon[i]).norm();
    return length;
}

/// Least distance of the origin inside the edges of a counter-clockwise convex polygon; negative outside.
double origin_depth(const Polygon& hull)
{
    double depth = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
        if (edge.norm() > 0.0) depth = std::min(depth, cross(edge, -hull[i]) / edge.norm());
    }
    return depth;
}

/// Closed chains of the section, as points in the plane around `centre`.
std::vector<Polygon> section_chains(const Eigen::Ref<const Points>& vertices,
                                    const Eigen::Ref<const Triangles>& triangles, const Eigen::Vector3d& centre,
                                    const Eigen::Vector3d& normal)
{
    const Eigen::Vector3d n = normal.normalized(), u = n.unitOrthogonal(), w = n.cross(u);
    // A vertex in the plane counts as above it, so that every section is made of edges cut in two.
    const Eigen::VectorXd height = (vertices.rowwise() - centre.transpose()) * n;
    struct Node {
        Eigen::Vector2d place;
        std::array<int, 2> next{-1, -1};
    };
    std::vector<Node> nodes;
    std::unordered_map<std::int64_t, int> node_of_edge;
    const auto node = [&](int a, int b) {
        if (a > b) std::swap(a, b);
        const auto [found, fresh] = node_of_edge.try_emplace(static_cast<std::int64_t>(a) * vertices.rows() + b,
                                                             static_cast<int>(nodes.size()));
        if (fresh) {
            const double t = height[a] / (height[a] - height[b]);
            const Eigen::Vector3d point =
                (vertices.row(a) + t * (vertices.row(b) - vertices.row(a))).transpose() - centre;
            nodes.push_back({{point.dot(u), point.dot(w)}, {-1, -1}});
        }
        return found->second;
    };
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<int, 2> cut{-1, -1};
        int count = 0;
        for (int k = 0; k < 3; ++k) {
            const int a = triangles(t, k), b = triangles(t, (k + 1) % 3);
            if ((height[a] >= 0.0) != (height[b] >= 0.0)) cut[count++] = node(a, b);
        }
        if (count != 2) continue;
        for (std::size_t i = 0; i < 2; ++i) {
            Node& from = nodes[cut[i]];
            from.next[from.next[0] < 0 ? 0 : 1] = cut[1 - i];
        }
    }
    std::vector<char> seen(nodes.size(), 0);
    std::vector<Polygon> chains;
    for (std::size_t start = 0; start < nodes.size(); ++start) {
        if (seen[start]) continue;
        Polygon chain;
        int at = static_cast<int>(start);
        while (at >= 0 && !seen[at]) {
            Node& current = nodes[at];
            seen[at] = 1;
            chain.push_back(current.place);
            at = -1;
            for (const int next : current.next)
                if (next >= 0 && !seen[next]) at = next;
        }
        chains.push_back(std::move(chain));
    }
    return chains;
}

/// Planes through a body's skin.
class Tape {
public:
    Tape(const Template& body_template, const Skin& skin) : template_(body_template), skin_(skin) {}

    Eigen::Vector3d joint(const std::string& name) const
    {
        return skin_.joint_positions.row(template_.skeleton.joint(name)).transpose();
    }
    Eigen::Vector3d landmark(const std::string& name) const
    {
        for (const Landmark& landmark : template_.landmarks) {
            if (landmark.name != name) continue;
            Eigen::Vector3d place = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k)
                place += landmark.barycentric[k] *
                         skin_.skin_vertices.row(template_.skin_triangles(landmark.skin_triangle_idx, k)).transpose();
            return place;
        }
        throw InputError("the template has no landmark '" + name + "', which girths are measured at");
    }
    double girth(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, const char* what) const
    {
        const double result = section_girth(skin_.skin_vertices, template_.skin_triangles, centre, normal);
        require_input(result > 0.0,
                      "body {}: no {} girth: the plane through ({:.3f}, {:.3f}, {:.3f}) m misses the skin", skin_.name,
                      what, centre[0], centre[1], centre[2]);
        return result;
    }
    /// Girths across the way between two places, at shares from `low` to `high` of it.
    std::vector<double> girths(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double low, double high,
                               int count, const char* what) const
    {
        std::vector<double> result;
        for (int i = 0; i < count; ++i) {
            const double share = count == 1 ? low : low + (high - low) * i / (count - 1);
            result.push_back(girth(from + share * (to - from), to - from, what));
        }
        return result;
    }
    double horizontal(double height, const char* what) const
    {
        // The trunk's middle at that height, on the line from pelvis to the root of the neck.
        const Eigen::Vector3d low = joint("pelvis"), high = joint("neck_1");
        Eigen::Vector3d centre = low + (height - low[1]) / (high[1] - low[1]) * (high - low);
        centre[1] = height;
        return girth(centre, Eigen::Vector3d::UnitY(), what);
    }

private:
    const Template& template_;
    const Skin& skin_;
};

double largest(const std::vector<double>& values)
{
    return *std::max_element(values.begin(), values.end());
}
double smallest(const std::vector<double>& values)
{
    return *std::min_element(values.begin(), values.end());
}

}  // namespace

double section_girth(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                     const Eigen::Vector3d& centre, const Eigen::Vector3d& normal)
{
    double best_depth = -std::numeric_limits<double>::max(), girth = 0.0;
    for (Polygon& chain : section_chains(vertices, triangles, centre, normal)) {
        if (chain.size() < 3) continue;
        const Polygon hull = convex_hull(std::move(chain));
        const double depth = origin_depth(hull);
        if (depth <= best_depth) continue;
        best_depth = depth;
        girth = perimeter(hull);
    }
    return girth;
}

BodyGirths measure_girths(const Template& body_template, const Skin& skin)
{
    const Tape tape(body_template, skin);
    BodyGirths girths;
    girths.neck = smallest(tape.girths(tape.joint("neck_1"), tape.joint("head"), 0.1, 0.9, 9, "neck"));
    const double navel = tape.landmark("navel")[1], notch = tape.landmark("suprasternale")[1];
    girths.abdomen = tape.horizontal(navel, "abdomen");
    // The lower end of the breast bone lies about halfway from navel to jugular notch.
    girths.waist = girths.abdomen;
    for (int i = 1; i <= 8; ++i)
        girths.waist = std::min(girths.waist, tape.horizontal(navel + 0.5 * i / 8.0 * (notch - navel), "waist"));
    girths.hip = tape.horizontal(0.5 * (tape.landmark("left_buttock")[1] + tape.landmark("right_buttock")[1]), "hip");
    for (const std::string side : {"left_", "right_"}) {
        const Eigen::Vector3d shoulder = tape.joint(side + "upper_arm"), elbow = tape.joint(side + "forearm");
        const Eigen::Vector3d wrist = tape.joint(side + "hand"), hip = tape.joint(side + "thigh");
        const Eigen::Vector3d knee = tape.joint(side + "shin"), ankle = tape.joint(side + "foot");
        girths.upper_arm += 0.5 * tape.girths(shoulder, elbow, 0.5, 0.5, 1, "upper arm").front();
        girths.forearm += 0.5 * largest(tape.girths(elbow, wrist, 0.1, 0.5, 7, "forearm"));
        girths.thigh += 0.5 * tape.girths(hip, knee, 0.5, 0.5, 1, "thigh").front();
        girths.calf += 0.5 * largest(tape.girths(knee, ankle, 0.15, 0.6, 7, "calf"));
    }
    return girths;
}

}  // namespace ndg
