// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/contact_surfaces.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/geometry/winding_tree.h"

#include <algorithm>
#include <set>

namespace ndg {

namespace {

/// One surface with vertices of its own, and where they are in the scene.
struct SurfaceMesh {
    SurfaceMesh(const ContactSurface& surface, const Points& positions, int num_given)
    {
        const Triangles& scene_triangles = surface.triangles;
        const std::set<int> used(scene_triangles.data(), scene_triangles.data() + scene_triangles.size());
        vertices.assign(used.begin(), used.end());
        points.resize(static_cast<Eigen::Index>(vertices.size()), 3);
        for (int i = 0; i < int(vertices.size()); ++i) points.row(i) = positions.row(vertices[i]);
        triangles.resize(scene_triangles.rows(), 3);
        for (Eigen::Index i = 0; i < triangles.size(); ++i) {
            const auto place = std::lower_bound(vertices.begin(), vertices.end(), scene_triangles.data()[i]);
            triangles.data()[i] = static_cast<int>(place - vertices.begin());
        }
        for (const int v : vertices) given.push_back(v < num_given);
        all_given = std::all_of(given.begin(), given.end(), [](char g) { return g != 0; });
        // A body's skin may be open at its rims, where winding numbers still tell inside from outside; cloth has none.
        has_inside = surface.kind != SurfaceKind::cloth;
        low = points.colwise().minCoeff();
        high = points.colwise().maxCoeff();
    }
    bool triangle_given(int t) const
    {
        return given[triangles(t, 0)] && given[triangles(t, 1)] && given[triangles(t, 2)];
    }
    bool in_box(const Eigen::RowVector3d& point) const
    {
        return (point.array() >= low.array()).all() && (point.array() <= high.array()).all();
    }

    std::vector<int> vertices;
    Points points;
    Triangles triangles;
    std::vector<char> given;
    bool all_given = false, has_inside = true;
    Eigen::RowVector3d low, high;
};

/// Vertices of the first inside the second.
Penetration vertices_inside(const SurfaceMesh& inner, const SurfaceMesh& outer)
{
    Penetration result;
    if (!outer.has_inside) return result;
    std::vector<Eigen::Index> candidates;
    for (Eigen::Index i = 0; i < inner.points.rows(); ++i) {
        if (outer.all_given && inner.given[static_cast<std::size_t>(i)]) continue;
        if (outer.in_box(inner.points.row(i))) candidates.push_back(i);
    }
    if (candidates.empty()) return result;
    const WindingTree winding(outer.points, outer.triangles);
    const TriangleTree tree(outer.points, outer.triangles);
    for (const Eigen::Index i : candidates) {
        const Eigen::Vector3d point = inner.points.row(i);
        if (winding.winding_number(point) < 0.5) continue;
        ++result.vertices;
        result.depth_metre = std::max(result.depth_metre, tree.closest(point).distance);
    }
    return result;
}

bool cross(const SurfaceMesh& a, const SurfaceMesh& b)
{
    for (const auto& [s, t] : crossing_triangles(a.points, a.triangles, b.points, b.triangles)) {
        if (!a.triangle_given(s) || !b.triangle_given(t)) return true;
    }
    return false;
}

}  // namespace

void describe(OptionList& list, ContactSceneOptions& options)
{
    list.add("contact", options.contact, "keep skin from skin, also where the scene has no obstacles");
    list.add("contact-distance", options.contact_distance, "distance from which surfaces repel each other, m", 1e-5,
             0.05);
    list.add("contact-stiffness", options.contact_stiffness_pascal, "scale of that pressure, Pa", 1, 1e9);
    list.add("friction-skin-obstacle", options.friction_skin_obstacle, "friction of skin on obstacles", 0, 10);
    list.add("friction-skin-skin", options.friction_skin_skin, "friction of skin on skin", 0, 10);
    list.add("friction-skin-cloth", options.friction_skin_cloth, "friction of skin on garments", 0, 10);
    list.add("friction-cloth-obstacle", options.friction_cloth_obstacle, "friction of garments on obstacles", 0, 10);
    list.add("friction-cloth-cloth", options.friction_cloth_cloth, "friction of garments on garments", 0, 10);
    list.add("friction-obstacle-obstacle", options.friction_obstacle_obstacle, "friction of thrown things on others", 0,
             10);
    list.add("slip-speed", options.slip_speed, "least speed that counts as sliding, m/s", 1e-6, 1);
    list.add("friction-solves", options.friction_solves, "solves of a step, each with the last one's normal forces", 1,
             20);
}

double friction_coefficient(const ContactSurface& a, const ContactSurface& b, const ContactSceneOptions& options)
{
    if (a.friction >= 0 && b.friction >= 0) return 0.5 * (a.friction + b.friction);
    if (a.friction >= 0 || b.friction >= 0) return std::max(a.friction, b.friction);
    const auto [low, high] = std::minmax(a.kind, b.kind);
    if (low == SurfaceKind::cloth) return options.friction_cloth_cloth;
    if (low == SurfaceKind::skin) {
        return high == SurfaceKind::skin ? options.friction_skin_skin : options.friction_skin_cloth;
    }
    if (high == SurfaceKind::obstacle) return options.friction_obstacle_obstacle;
    return high == SurfaceKind::skin ? options.friction_skin_obstacle : options.friction_cloth_obstacle;
}

std::vector<Penetration> find_penetrations(const std::vector<ContactSurface>& surfaces, const Points& positions,
                                           int num_given)
{
    std::vector<SurfaceMesh> meshes;
    for (const ContactSurface& surface : surfaces) meshes.emplace_back(surface, positions, num_given);
    std::vector<Penetration> result;
    const auto add = [&](Penetration penetration, std::size_t inner, std::size_t outer) {
        penetration.inner = surfaces[inner].name;
        penetration.outer = surfaces[outer].name;
        result.push_back(std::move(penetration));
    };
    for (std::size_t s = 0; s < meshes.size(); ++s) {
        for (std::size_t t = s + 1; t < meshes.size(); ++t) {
            if (meshes[s].all_given && meshes[t].all_given) continue;
            const std::size_t before = result.size();
            const Penetration first = vertices_inside(meshes[s], meshes[t]);
            if (first.vertices > 0) add(first, s, t);
            const Penetration second = vertices_inside(meshes[t], meshes[s]);
            if (second.vertices > 0) add(second, t, s);
            if (result.size() == before && cross(meshes[s], meshes[t])) add({}, s, t);
        }
    }
    return result;
}

void check_apart(const std::vector<ContactSurface>& surfaces, const Points& positions, int num_given)
{
    const std::vector<Penetration> penetrations = find_penetrations(surfaces, positions, num_given);
    if (penetrations.empty()) return;
    const Penetration& worst =
        *std::max_element(penetrations.begin(), penetrations.end(),
                          [](const Penetration& a, const Penetration& b) { return a.depth_metre < b.depth_metre; });
    require_input(worst.vertices > 0, "{} and {} cross each other at the start", worst.inner, worst.outer);
    throw InputError(fmt::format("{} starts inside {}: {} of its vertices, the deepest by {:.1f} mm", worst.inner,
                                 worst.outer, worst.vertices, 1e3 * worst.depth_metre));
}

}  // namespace ndg
