// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/garment.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/section_hull.h"
#include "ndg/geometry/triangle_crossings.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double farthest_offset = 0.05, offset_factor = 1.4;
/// Of cloth, which a garment's bending hardly depends on.
constexpr double cloth_poisson_ratio = 0.3;

Eigen::Vector2d centroid(const std::vector<Eigen::Vector2d>& points)
{
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& point : points) sum += point;
    return sum / static_cast<double>(points.size());
}

/// The hull moved outwards: every edge goes along its normal, rounded at the corners by one point each.
std::vector<Eigen::Vector2d> outset(const std::vector<Eigen::Vector2d>& hull, double offset)
{
    std::vector<Eigen::Vector2d> result;
    const std::size_t n = hull.size();
    const auto normal = [&](std::size_t i) {
        const Eigen::Vector2d edge = hull[(i + 1) % n] - hull[i];
        return Eigen::Vector2d(edge[1], -edge[0]).normalized();
    };
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector2d before = normal((i + n - 1) % n), after = normal(i);
        result.push_back(hull[i] + offset * before);
        result.push_back(hull[i] + offset * (before + after).normalized());
        result.push_back(hull[i] + offset * after);
    }
    return result;
}

/// As many points at equal ways along a closed line, the first where the ray of that angle from `centre` leaves it.
std::vector<Eigen::Vector2d> resample(const std::vector<Eigen::Vector2d>& line, const Eigen::Vector2d& centre,
                                      int count, double first_share)
{
    const std::size_t n = line.size();
    std::vector<double> way(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i) way[i + 1] = way[i] + (line[(i + 1) % n] - line[i]).norm();
    double begin = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector2d a = line[i] - centre, b = line[(i + 1) % n] - centre;
        if (!(a[1] <= 0 && b[1] > 0) || std::max(a[0], b[0]) <= 0) continue;
        begin = way[i] + a[1] / (a[1] - b[1]) * (way[i + 1] - way[i]);
    }
    std::vector<Eigen::Vector2d> points;
    for (int k = 0; k < count; ++k) {
        const double at = std::fmod(begin + way[n] * (k + first_share) / count, way[n]);
        const auto next = std::upper_bound(way.begin() + 1, way.end() - 1, at);
        const std::size_t i = static_cast<std::size_t>(next - way.begin()) - 1;
        const double length = way[i + 1] - way[i];
        const double share = length > 0 ? (at - way[i]) / length : 0;
        points.push_back(line[i] + share * (line[(i + 1) % n] - line[i]));
    }
    return points;
}

struct Tube {
    Points worn, rest;
    Triangles triangles;
};

Tube make_tube(const std::vector<SectionHull>& rings, int around, double offset, double rest_share)
{
    const int num_rings = static_cast<int>(rings.size());
    Tube tube{Points(num_rings * around, 3), Points(num_rings * around, 3), Triangles(2 * (num_rings - 1) * around, 3)};
    for (int r = 0; r < num_rings; ++r) {
        const std::vector<Eigen::Vector2d> line = outset(rings[r].points, offset);
        const Eigen::Vector2d centre = centroid(line);
        double length = 0;
        for (std::size_t i = 0; i < line.size(); ++i) length += (line[(i + 1) % line.size()] - line[i]).norm();
        const double scale = rest_share * rings[r].girth() / length;
        const std::vector<Eigen::Vector2d> points = resample(line, centre, around, 0.5 * (r % 2));
        for (int k = 0; k < around; ++k) {
            tube.worn.row(r * around + k) = rings[r].in_space(points[k]).transpose();
            tube.rest.row(r * around + k) = rings[r].in_space(centre + scale * (points[k] - centre)).transpose();
        }
    }
    const auto at = [&](int ring, int k) { return ring * around + k % around; };
    int t = 0;
    for (int r = 0; r + 1 < num_rings; ++r) {
        for (int k = 0; k < around; ++k) {
            // Every other ring is turned by half an edge.
            if (r % 2 == 0) {
                tube.triangles.row(t++) << at(r, k), at(r, k + 1), at(r + 1, k);
                tube.triangles.row(t++) << at(r, k + 1), at(r + 1, k + 1), at(r + 1, k);
            } else {
                tube.triangles.row(t++) << at(r, k), at(r, k + 1), at(r + 1, k + 1);
                tube.triangles.row(t++) << at(r, k), at(r + 1, k + 1), at(r + 1, k);
            }
        }
    }
    return tube;
}

bool apart(const TriangleMesh& garment, const Eigen::Ref<const Points>& skin_vertices,
           const Eigen::Ref<const Triangles>& skin_triangles, double least_distance)
{
    if (!crossing_triangles(garment.vertices, garment.triangles, skin_vertices, skin_triangles).empty()) return false;
    const TriangleTree skin(skin_vertices, skin_triangles), cloth(garment.vertices, garment.triangles);
    const Eigen::RowVector3d low = garment.vertices.colwise().minCoeff().array() - least_distance,
                             high = garment.vertices.colwise().maxCoeff().array() + least_distance;
    for (Eigen::Index v = 0; v < garment.vertices.rows(); ++v) {
        if (skin.closest(garment.vertices.row(v)).distance < least_distance) return false;
    }
    for (Eigen::Index v = 0; v < skin_vertices.rows(); ++v) {
        const auto point = skin_vertices.row(v);
        if ((point.array() < low.array()).any() || (point.array() > high.array()).any()) continue;
        if (cloth.closest(point).distance < least_distance) return false;
    }
    return true;
}

}  // namespace

Points Garment::rest_at(double time) const
{
    const double share = shrink_seconds > 0 ? std::clamp(time / shrink_seconds, 0.0, 1.0) : 1;
    const double smooth = share * share * (3 - 2 * share);
    return worn.vertices + smooth * (rest - worn.vertices);
}

Eigen::VectorXd Garment::masses() const
{
    return material.density * material.thickness * vertex_areas(worn.vertices, worn.triangles);
}

Garment make_garment(const GarmentPlan& plan, const Eigen::Ref<const Points>& skin_vertices,
                     const Eigen::Ref<const Triangles>& skin_triangles, const JointPlaces& joints,
                     double least_distance)
{
    Garment garment;
    garment.name = plan.name;
    garment.shrink_seconds = plan.shrink_seconds;
    garment.material = plan.material;
    garment.friction = plan.friction;
    if (plan.mesh.triangles.rows() > 0) {
        garment.worn = plan.mesh;
        garment.rest = plan.rest_share * plan.mesh.vertices;
        return garment;
    }
    const Eigen::Vector3d from = joints(plan.from_joint), along = joints(plan.to_joint) - from;
    const double length = (plan.to - plan.from) * along.norm();
    require_input(length > plan.edge, "garment {}: {} m long, less than its edges of {} m", plan.name, length,
                  plan.edge);
    const int num_rings = 1 + std::max(1, static_cast<int>(std::round(length / (0.87 * plan.edge))));
    std::vector<SectionHull> rings;
    double girth = 0;
    for (int r = 0; r < num_rings; ++r) {
        const double share = plan.from + (plan.to - plan.from) * r / (num_rings - 1);
        rings.push_back(section_hull(skin_vertices, skin_triangles, from + share * along, along));
        require_input(rings.back().points.size() >= 3,
                      "garment {}: at {:.2f} of the way from {} to {} there is no skin", plan.name, share,
                      plan.from_joint, plan.to_joint);
        girth = std::max(girth, rings.back().girth());
    }
    const int around = std::max(6, static_cast<int>(std::round(girth / plan.edge)));
    for (double offset = plan.offset; offset <= farthest_offset; offset *= offset_factor) {
        const Tube tube = make_tube(rings, around, offset, plan.rest_share);
        garment.worn = {tube.worn, tube.triangles};
        garment.rest = tube.rest;
        if (apart(garment.worn, skin_vertices, skin_triangles, least_distance)) return garment;
    }
    throw InputError(fmt::format("garment {}: a tube from {:.2f} to {:.2f} of the way from {} to {} meets other skin",
                                 plan.name, plan.from, plan.to, plan.from_joint, plan.to_joint));
}

std::unique_ptr<SkinTerm> cloth_term(const Garment& garment, int first_vertex, int num_vertices)
{
    const ClothMaterial& material = garment.material;
    const std::vector<MeshEdge> edges =
        mesh_edges(garment.worn.triangles, static_cast<int>(garment.worn.vertices.rows()));
    double squared = 0;
    for (const MeshEdge& edge : edges) squared += (garment.rest.row(edge.v0) - garment.rest.row(edge.v1)).squaredNorm();
    squared /= static_cast<double>(edges.size());
    const double stretch = 0.5 * std::sqrt(3.0) * material.young_pascal * material.thickness * squared;
    const double bend = material.young_pascal * std::pow(material.thickness, 3) /
                        (12 * (1 - cloth_poisson_ratio * cloth_poisson_ratio));
    const Triangles triangles = garment.worn.triangles.array() + first_vertex;
    return std::make_unique<SkinTerm>(triangles, stretch, bend, num_vertices);
}

}  // namespace ndg
