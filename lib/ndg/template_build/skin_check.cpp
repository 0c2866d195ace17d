// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/skin_check.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <utility>
#include <vector>

namespace ndg {
namespace {

constexpr double least_stature = 1.2, greatest_stature = 2.3;  ///< m, of adults
/// kg/m^2; the range survived by adults is about 10 to 100, a mesh outside 11 to 90 is no plausible body.
constexpr double least_bmi = 11.0, greatest_bmi = 90.0;
constexpr double floor_tolerance = 0.02;  ///< m

std::string place(const Eigen::RowVector3d& point)
{
    return fmt::format("{:.4g} {:.4g} {:.4g}", point[0], point[1], point[2]);
}

void check_indices(const ParametricSurface& skin, const std::string& name)
{
    require_input(skin.vertices.rows() > 0 && skin.triangles.rows() > 0,
                  "{}: the skin has {} vertices and {} triangles", name, skin.vertices.rows(), skin.triangles.rows());
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v)
        require_input(skin.vertices.row(v).allFinite(), "{}: skin vertex {} is not finite", name, v);
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t) {
        const auto corners = skin.triangles.row(t);
        require_input(corners.minCoeff() >= 0 && corners.maxCoeff() < skin.vertices.rows(),
                      "{}: skin triangle {} names vertex {}, but there are {}", name, t,
                      corners.minCoeff() < 0 ? corners.minCoeff() : corners.maxCoeff(), skin.vertices.rows());
        require_input(corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0],
                      "{}: skin triangle {} names a vertex twice", name, t);
    }
}

/// Directed edges with their triangles. More than one triangle on a directed edge is non-manifold or badly oriented.
void check_edges(const ParametricSurface& skin, const std::string& name)
{
    std::map<std::pair<int, int>, std::array<int, 2>> runs;  // of each edge: triangles that run up, that run down
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) {
            const int a = skin.triangles(t, k), b = skin.triangles(t, (k + 1) % 3);
            ++runs[std::minmax(a, b)][a < b ? 0 : 1];
        }
    std::size_t open = 0;
    for (const auto& [edge, count] : runs) {
        const Eigen::RowVector3d middle = 0.5 * (skin.vertices.row(edge.first) + skin.vertices.row(edge.second));
        require_input(count[0] + count[1] <= 2,
                      "{}: the skin is not manifold: {} triangles meet at the edge of vertices {} and {} at {}", name,
                      count[0] + count[1], edge.first, edge.second, place(middle));
        require_input(count[0] <= 1 && count[1] <= 1,
                      "{}: the two triangles at the edge of skin vertices {} and {} at {} face opposite ways", name,
                      edge.first, edge.second, place(middle));
        open += count[0] + count[1] == 1 ? 1 : 0;
    }
    if (open == 0) return;
    const auto loops = boundary_loops(skin.triangles, static_cast<int>(skin.vertices.rows()));
    const auto longest =
        std::max_element(loops.begin(), loops.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    const Eigen::RowVector3d centre = skin.vertices(*longest, Eigen::all).colwise().mean();
    throw InputError(
        fmt::format("{}: the skin is open: it has {} boundary {} with {} edges in all, the longest of {} "
                    "edges around {}",
                    name, loops.size(), loops.size() == 1 ? "loop" : "loops", open, longest->size(), place(centre)));
}

/// Every vertex must have one fan, and all triangles must hang together.
void check_connection(const ParametricSurface& skin, const std::string& name)
{
    const int count = static_cast<int>(skin.vertices.rows());
    std::vector<std::vector<int>> around(count);
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) around[skin.triangles(t, k)].push_back(static_cast<int>(t));
    for (int v = 0; v < count; ++v) {
        const auto& fan = around[v];
        require_input(!fan.empty(), "{}: skin vertex {} at {} belongs to no triangle", name, v,
                      place(skin.vertices.row(v)));
        std::map<int, int> next;  // round the vertex, from one neighbour to the next
        for (const int t : fan)
            for (int k = 0; k < 3; ++k)
                if (skin.triangles(t, k) == v) next[skin.triangles(t, (k + 1) % 3)] = skin.triangles(t, (k + 2) % 3);
        std::size_t steps = 0;
        int at = next.begin()->first;
        do {
            at = next.at(at);
            ++steps;
        } while (at != next.begin()->first && steps <= fan.size());
        require_input(steps == fan.size(),
                      "{}: the skin is not manifold: its parts touch at the single vertex {} at {}", name, v,
                      place(skin.vertices.row(v)));
    }
    std::vector<int> part(count, -1);
    std::vector<std::pair<int, int>> parts;  // vertices of each and one of them
    for (int start = 0; start < count; ++start) {
        if (part[start] >= 0) continue;
        const int number = static_cast<int>(parts.size());
        parts.push_back({0, start});
        std::queue<int> open({start});
        part[start] = number;
        while (!open.empty()) {
            const int v = open.front();
            open.pop();
            ++parts.back().first;
            for (const int t : around[v])
                for (int k = 0; k < 3; ++k) {
                    int& other = part[skin.triangles(t, k)];
                    if (other >= 0) continue;
                    other = number;
                    open.push(skin.triangles(t, k));
                }
        }
    }
    if (parts.size() == 1) return;
    const auto smallest = std::min_element(parts.begin(), parts.end());
    throw InputError(
        fmt::format("{}: the skin is in {} parts, but has to be one; the smallest has {} vertices, one at {}", name,
                    parts.size(), smallest->first, place(skin.vertices.row(smallest->second))));
}

void check_upright(const ParametricSurface& skin, const std::string& name)
{
    const Eigen::RowVector3d size = skin.vertices.colwise().maxCoeff() - skin.vertices.colwise().minCoeff();
    // A standing body is at most about as wide (arms out) as high, and never as deep.
    constexpr double widest = 1.25, deepest = 0.6;
    require_input(size[2] <= deepest * size[1] && size[0] <= widest * size[1],
                  "{}: the skin is not a standing body with y up: it measures {:.4g} (x) by {:.4g} (y) by {:.4g} (z)",
                  name, size[0], size[1], size[2]);
}

void set_unit(ParametricSurface& skin, const std::string& name)
{
    const double height = skin.vertices.col(1).maxCoeff() - skin.vertices.col(1).minCoeff();
    const std::array<std::pair<double, const char*>, 4> units{
        {{1.0, "metres"}, {0.1, "decimetres"}, {0.01, "centimetres"}, {0.001, "millimetres"}}};
    for (const auto& [metres, unit] : units) {
        if (height * metres < least_stature || height * metres > greatest_stature) continue;
        if (metres == 1.0) return;
        skin.vertices *= metres;
        skin.joint_positions *= metres;
        log_warning("{}: the skin is {:.4g} high, taken to be in {}: scaled to {:.3f} m", name, height, unit,
                    height * metres);
        return;
    }
    throw InputError(
        fmt::format("{}: the skin is {:.4g} high, which is no adult's stature ({} to {} m) in metres, "
                    "decimetres, centimetres or millimetres",
                    name, height, least_stature, greatest_stature));
}

void check_joints(const ParametricSurface& skin, const std::string& name)
{
    const Skeleton& skeleton = standard_skeleton();
    if (skin.joint_positions.rows() == 0) return;
    require_input(skin.joint_positions.rows() == skeleton.num_joints(), "{}: {} joint positions instead of {}", name,
                  skin.joint_positions.rows(), skeleton.num_joints());
    const Eigen::RowVector3d low = skin.vertices.colwise().minCoeff(), high = skin.vertices.colwise().maxCoeff();
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const Eigen::RowVector3d point = skin.joint_positions.row(j);
        require_input((point.array() >= low.array()).all() && (point.array() <= high.array()).all(),
                      "{}: joint {} at {} lies outside the skin's box from {} to {}", name, skeleton.joint_names[j],
                      place(point), place(low), place(high));
    }
    const auto at = [&](const char* joint) -> Eigen::RowVector3d {
        return skin.joint_positions.row(skeleton.joint(joint));
    };
    require_input(at("head")[1] > at("pelvis")[1] && at("pelvis")[1] > at("left_foot")[1],
                  "{}: the body does not stand: head, pelvis and left foot are at heights {:.3f}, {:.3f} and {:.3f} m",
                  name, at("head")[1], at("pelvis")[1], at("left_foot")[1]);
    require_input(at("left_hand")[0] > at("right_hand")[0],
                  "{}: the body's left hand (x = {:.3f} m) is not on the side of +x of its right hand (x = {:.3f} m)",
                  name, at("left_hand")[0], at("right_hand")[0]);
    require_input(at("left_toes")[2] > at("left_foot")[2],
                  "{}: the body does not face +z: its left toes are at z = {:.3f} m, the ankle at {:.3f} m", name,
                  at("left_toes")[2], at("left_foot")[2]);
}

}  // namespace

ParametricSurface checked_skin(ParametricSurface skin, const std::string& name)
{
    check_indices(skin, name);
    check_edges(skin, name);
    check_connection(skin, name);
    check_upright(skin, name);
    set_unit(skin, name);
    if (enclosed_volume(skin.vertices, skin.triangles) < 0.0) {
        skin.triangles.col(1).swap(skin.triangles.col(2));
        log_warning("{}: the skin faces inwards: turned", name);
    }
    const double floor = skin.vertices.col(1).minCoeff();
    if (std::abs(floor) > floor_tolerance) {
        skin.vertices.col(1).array() -= floor;
        if (skin.joint_positions.rows() > 0) skin.joint_positions.col(1).array() -= floor;
        log_warning("{}: the skin's lowest point was at y = {:.3f} m: put onto y = 0", name, floor);
    }
    const double height = stature(skin.vertices);
    const double volume = enclosed_volume(skin.vertices, skin.triangles);
    const double bmi = body_density * volume / (height * height);
    require_input(bmi >= least_bmi && bmi <= greatest_bmi,
                  "{}: the skin encloses {:.1f} litres at a height of {:.2f} m (a BMI of {:.1f}), which is no adult",
                  name, 1e3 * volume, height, bmi);
    check_joints(skin, name);
    return skin;
}

}  // namespace ndg
