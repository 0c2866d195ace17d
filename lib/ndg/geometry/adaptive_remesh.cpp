// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/adaptive_remesh.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/dynamic_mesh.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace ndg {
namespace {

constexpr int iterations = 10;
/// The first iterations even out valences, which lets the mesh grow regular; the others flip for angles.
constexpr int valence_iterations = 5;
constexpr int smoothing_steps = 4;
constexpr double longest = 4.0 / 3.0, shortest = 4.0 / 5.0;  ///< of the wanted length (Botsch and Kobbelt 2004)
constexpr double least_agreement = 0.3;              ///< cosine between a triangle and the surface below its corners
constexpr double wide_enough = 34.0 * M_PI / 180.0;  ///< angles above this are not worked on
constexpr int widening_sweeps = 12;

class Remesher {
public:
    Remesher(const TriangleMesh& source, const std::vector<int>& labels, const RemeshField& field)
        : mesh_(source.vertices, source.triangles, labels),
          source_(source),
          field_(field.edge_length),
          tree_(source.vertices, source.triangles),
          normals_of_source_(vertex_normals(source.vertices, source.triangles)),
          fixed_(field.fixed)
    {
        for (Eigen::Index v = 0; v < source.vertices.rows(); ++v) {
            size_.push_back(field.edge_length[v]);
            normal_.emplace_back(normals_of_source_.row(v).transpose());
        }
        for (const auto& [a, b] : mesh_.edges())
            if (mesh_.is_feature(a, b)) curves_[curve_of(a, b)].push_back({a, b});
    }

    LabelledMesh run()
    {
        for (int iteration = 0; iteration < iterations; ++iteration) {
            split_long();
            collapse_short();
            flip(iteration < valence_iterations);
            for (int step = 0; step < smoothing_steps; ++step) smooth();
        }
        flip(false);
        for (int sweep = 0; sweep < widening_sweeps; ++sweep) widen(sweep);
        split_edges_across();
        LabelledMesh result;
        mesh_.compact(result.mesh.vertices, result.mesh.triangles, result.triangle_labels);
        return result;
    }

private:
    using Curve = std::array<int, 2>;  ///< labels on either side, -1 beyond the boundary
    struct Place {
        Eigen::Vector3d position, normal;
        double size = 0.0;
    };

    Curve curve_of(int a, int b) const
    {
        const auto [left, right] = mesh_.edge_triangles(a, b);
        Curve curve{left < 0 ? -1 : mesh_.label(left), right < 0 ? -1 : mesh_.label(right)};
        std::sort(curve.begin(), curve.end());
        return curve;
    }

    /// Nearest place of the input surface.
    Place on_surface(const Eigen::Vector3d& point) const
    {
        const ClosestPoint closest = tree_.closest(point);
        Place place{closest.point, Eigen::Vector3d::Zero(), 0.0};
        for (int k = 0; k < 3; ++k) {
            const int v = source_.triangles(closest.triangle_idx, k);
            place.size += closest.barycentric[k] * field_[v];
            place.normal += closest.barycentric[k] * normals_of_source_.row(v).transpose();
        }
        place.normal.normalize();
        return place;
    }

    /// Nearest place of a feature of the input.
    Place on_curve(const Curve& curve, const Eigen::Vector3d& point) const
    {
        const ClosestOnSegments closest = closest_on_segments(source_.vertices, curves_.at(curve), point);
        const auto [first, second] = closest.segment;
        const double share = closest.share;
        const Eigen::RowVector3d normal =
            (1.0 - share) * normals_of_source_.row(first) + share * normals_of_source_.row(second);
        return {closest.point, normal.normalized().transpose(), (1.0 - share) * field_[first] + share * field_[second]};
    }

    void put(int v, const Place& place)
    {
        mesh_.positions[index(v)] = place.position;
        normal_[index(v)] = place.normal;
        size_[index(v)] = place.size;
    }
    static std::size_t index(int v) { return static_cast<std::size_t>(v); }
    bool fixed(int v) const { return fixed_[index(v)] != 0; }
    double length(int a, int b) const { return (mesh_.position(a) - mesh_.position(b)).norm(); }
    double wanted(int a, int b) const { return 0.5 * (size_[index(a)] + size_[index(b)]); }

    /// How well a triangle keeps to the surface below its corners: the least cosine between its normal and theirs,
    /// -1 for a flat one.
    double agreement(const std::array<int, 3>& corners) const
    {
        const Eigen::Vector3d &a = mesh_.position(corners[0]), &b = mesh_.position(corners[1]),
                              &c = mesh_.position(corners[2]);
        const Eigen::Vector3d area = (b - a).cross(c - a);
        const double longest_squared = std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
        if (area.norm() <= 1e-6 * longest_squared) return -1.0;
        double least = 1.0;
        for (const int v : corners) least = std::min(least, area.dot(normal_[index(v)]) / area.norm());
        return least;
    }
    double angle(const std::array<int, 3>& corners) const
    {
        return DynamicMesh::min_angle(mesh_.position(corners[0]), mesh_.position(corners[1]),
                                      mesh_.position(corners[2]));
    }
    /// Least agreement and least angle of the triangles of a vertex.
    double star_agreement(int v) const { return star_least(v, 1.0, &Remesher::agreement); }
    double star_angle(int v) const { return star_least(v, M_PI, &Remesher::angle); }
    double star_least(int v, double least, double (Remesher::*measure)(const std::array<int, 3>&) const) const
    {
        for (const int t : mesh_.triangles_of(v)) least = std::min(least, (this->*measure)(mesh_.triangle(t)));
        return least;
    }

    int split(int a, int b)
    {
        const Eigen::Vector3d middle = 0.5 * (mesh_.position(a) + mesh_.position(b));
        const Place place = mesh_.is_feature(a, b) ? on_curve(curve_of(a, b), middle) : on_surface(middle);
        const int added = mesh_.split(a, b, middle);
        size_.push_back(place.size);
        normal_.push_back(place.normal);
        fixed_.push_back(0);
        put(added, place);
        return added;
    }

    /// Edges of the input that run across between two boundary vertices and were never split.
    void split_edges_across()
    {
        for (const auto& [a, b] : mesh_.edges()) {
            if (fixed(a) && fixed(b)) continue;
            if (mesh_.on_boundary(a) && mesh_.on_boundary(b) && !mesh_.is_boundary(a, b)) split(a, b);
        }
    }

    void split_long()
    {
        constexpr int max_sweeps = 8;
        for (int sweep = 0; sweep < max_sweeps; ++sweep) {
            std::vector<std::pair<double, std::array<int, 2>>> long_edges;
            for (const auto& edge : mesh_.edges()) {
                const auto [a, b] = edge;
                if (fixed(a) && fixed(b)) continue;
                const double excess = length(a, b) / wanted(a, b);
                if (excess > longest) long_edges.push_back({-excess, edge});
            }
            if (long_edges.empty()) return;
            std::sort(long_edges.begin(), long_edges.end());  // longest first
            for (const auto& [excess, edge] : long_edges) {
                const auto [a, b] = edge;
                const int added = split(a, b);
                // Where the surface turns too sharply for the new vertex the edge is left as it was.
                if (star_agreement(added) < least_agreement) mesh_.collapse(added, a);
            }
        }
    }

    /// Whether the surface around `removed` stays sound and no edge gets too long when it is merged into `kept`.
    bool collapse_is_sound(int removed, int kept) const
    {
        double before = 1.0, after = 1.0;
        for (const int t : mesh_.triangles_of(removed)) {
            auto corners = mesh_.triangle(t);
            before = std::min(before, agreement(corners));
            if (std::find(corners.begin(), corners.end(), kept) != corners.end()) continue;
            for (const int v : corners)
                if (v != removed && length(v, kept) > longest * wanted(v, kept)) return false;
            std::replace(corners.begin(), corners.end(), removed, kept);
            after = std::min(after, agreement(corners));
        }
        return after >= std::min(least_agreement, before + 1e-9);
    }

    bool try_collapse(int removed, int kept)
    {
        if (fixed(removed) || !mesh_.can_collapse(removed, kept) || !collapse_is_sound(removed, kept)) return false;
        mesh_.collapse(removed, kept);
        return true;
    }

    void collapse_short()
    {
        constexpr int max_sweeps = 8;
        for (int sweep = 0; sweep < max_sweeps; ++sweep) {
            std::vector<std::pair<double, std::array<int, 2>>> short_edges;
            for (const auto& edge : mesh_.edges()) {
                const double share = length(edge[0], edge[1]) / wanted(edge[0], edge[1]);
                if (share < shortest) short_edges.push_back({share, edge});
            }
            std::sort(short_edges.begin(), short_edges.end());
            int collapsed = 0;
            for (const auto& [share, edge] : short_edges) {
                const auto [a, b] = edge;
                const auto both = mesh_.edge_triangles(a, b);
                if (both[0] < 0 && both[1] < 0) continue;  // gone with an earlier collapse
                if (length(a, b) >= shortest * wanted(a, b)) continue;
                if (try_collapse(b, a) || try_collapse(a, b)) ++collapsed;
            }
            if (collapsed == 0) return;
        }
    }

    int valence_excess(int v, int change) const
    {
        // The boundary sees half a neighbourhood.
        const auto count = static_cast<int>(mesh_.triangles_of(v).size());
        return std::abs(count + change - (mesh_.on_boundary(v) ? 3 : 6));
    }

    bool flip_is_sound(int a, int b, int c, int d) const
    {
        const double after = std::min(agreement({a, d, c}), agreement({d, b, c}));
        const double before = std::min(agreement({a, b, c}), agreement({b, a, d}));
        return after >= std::min(least_agreement, before);
    }

    void flip(bool for_valence)
    {
        constexpr int max_sweeps = 6;
        for (int sweep = 0; sweep < max_sweeps; ++sweep) {
            int flipped = 0;
            for (const auto& [a, b] : mesh_.edges()) {
                if ((fixed(a) && fixed(b)) || !mesh_.can_flip(a, b)) continue;
                const auto [left, right] = mesh_.edge_triangles(a, b);
                const int c = mesh_.opposite(left, a, b), d = mesh_.opposite(right, a, b);
                const double before = std::min(angle({a, b, c}), angle({b, a, d}));
                const double after = std::min(angle({a, d, c}), angle({d, b, c}));
                bool better = after > before + 1e-6;
                if (for_valence) {
                    const int now =
                        valence_excess(a, 0) + valence_excess(b, 0) + valence_excess(c, 0) + valence_excess(d, 0);
                    const int then =
                        valence_excess(a, -1) + valence_excess(b, -1) + valence_excess(c, 1) + valence_excess(d, 1);
                    better = then < now && after > std::min(before, 0.35);
                    if (before < 0.1 && after > before) better = true;
                }
                if (!better || !flip_is_sound(a, b, c, d)) continue;
                mesh_.flip(a, b);
                ++flipped;
            }
            if (flipped == 0) return;
        }
    }

    /// Moves a vertex along the surface, or its feature, towards `goal`, unless that spoils its triangles.
    bool move(int v, const std::vector<int>& feature, const Eigen::Vector3d& goal)
    {
        const Place old{mesh_.position(v), normal_[index(v)], size_[index(v)]};
        const double before = star_agreement(v);
        Place place;
        if (feature.empty()) {
            const Eigen::Vector3d step = goal - old.position;
            place = on_surface(old.position + step - step.dot(old.normal) * old.normal);
        } else {
            place = on_curve(curve_of(v, feature[0]), goal);
        }
        put(v, place);
        if (star_agreement(v) >= std::min(least_agreement, before)) return true;
        put(v, old);
        return false;
    }

    /// False for vertices that may not move: fixed ones and those where features meet.
    bool movable(int v, std::vector<int>& feature) const
    {
        if (fixed(v) || mesh_.triangles_of(v).empty()) return false;
        feature = mesh_.feature_neighbours(v);
        if (feature.empty()) return true;
        return feature.size() == 2 && curve_of(v, feature[0]) == curve_of(v, feature[1]);
    }

    void smooth()
    {
        std::vector<int> feature;
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            if (!movable(v, feature)) continue;
            Eigen::Vector3d goal = Eigen::Vector3d::Zero();
            double total = 0.0;
            if (feature.empty()) {  // centroids of the triangles by area, counted in triangles of the wanted size
                for (const int t : mesh_.triangles_of(v)) {
                    const auto& [a, b, c] = mesh_.triangle(t);
                    const Eigen::Vector3d &pa = mesh_.position(a), &pb = mesh_.position(b), &pc = mesh_.position(c);
                    const double size = (size_[index(a)] + size_[index(b)] + size_[index(c)]) / 3.0;
                    const double weight = (pb - pa).cross(pc - pa).norm() / (size * size);
                    goal += weight * (pa + pb + pc) / 3.0;
                    total += weight;
                }
            } else {
                for (const int other : feature) {
                    const double weight = length(v, other) / wanted(v, other);
                    goal += weight * 0.5 * (mesh_.position(v) + mesh_.position(other));
                    total += weight;
                }
            }
            if (total > 0.0) move(v, feature, goal / total);
        }
    }

    /// Local search for the vertices of small angles: other places nearby on the surface; and flips. Where a small
    /// angle stays, the short side opposite it is collapsed.
    void widen(int sweep)
    {
        constexpr int directions = 8;
        const double reach = 0.3 * std::pow(0.8, sweep);
        std::vector<int> feature;
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            if (!movable(v, feature)) continue;
            double best = star_angle(v);
            if (best >= wide_enough) continue;
            Place best_place{mesh_.position(v), normal_[index(v)], size_[index(v)]};
            const Place start = best_place;
            const double radius = reach * start.size;
            std::vector<Eigen::Vector3d> goals;
            if (feature.empty()) {
                const Eigen::Vector3d u = start.normal.unitOrthogonal(), w = start.normal.cross(u);
                for (int k = 0; k < directions; ++k) {
                    const double turn = 2.0 * M_PI * k / directions;
                    goals.emplace_back(start.position + radius * (std::cos(turn) * u + std::sin(turn) * w));
                }
            } else {
                for (const int other : feature)
                    goals.emplace_back(start.position + radius * (mesh_.position(other) - start.position).normalized());
            }
            for (const auto& goal : goals) {
                put(v, start);
                if (!move(v, feature, goal)) continue;
                const double reached = star_angle(v);
                if (reached <= best) continue;
                best = reached;
                best_place = {mesh_.position(v), normal_[index(v)], size_[index(v)]};
            }
            put(v, best_place);
        }
        flip(false);
        if (sweep % 3 != 2) return;
        for (const auto& [a, b] : mesh_.edges()) {
            const auto both = mesh_.edge_triangles(a, b);
            if (both[0] < 0 && both[1] < 0) continue;
            double least = M_PI;
            for (const int t : both)
                if (t >= 0) least = std::min(least, angle(mesh_.triangle(t)));
            if (least > 0.45 || length(a, b) > 0.75 * wanted(a, b)) continue;
            (void)(try_collapse(b, a) || try_collapse(a, b));
        }
    }

    DynamicMesh mesh_;
    const TriangleMesh& source_;
    const Eigen::VectorXd& field_;
    TriangleTree tree_;
    Points normals_of_source_;
    std::vector<char> fixed_;
    std::vector<double> size_;             ///< wanted edge length at each vertex
    std::vector<Eigen::Vector3d> normal_;  ///< of the input surface at each vertex
    std::map<Curve, std::vector<std::array<int, 2>>> curves_;
};

}  // namespace

LabelledMesh remesh_adaptively(const TriangleMesh& mesh, const std::vector<int>& triangle_labels,
                               const RemeshField& field)
{
    require_input(field.edge_length.size() == mesh.vertices.rows() &&
                      static_cast<Eigen::Index>(field.fixed.size()) == mesh.vertices.rows(),
                  "the mesh to remesh has {} vertices but {} edge lengths and {} flags", mesh.vertices.rows(),
                  field.edge_length.size(), field.fixed.size());
    for (Eigen::Index v = 0; v < field.edge_length.size(); ++v)
        require_input(std::isfinite(field.edge_length[v]) && field.edge_length[v] > 0.0,
                      "the wanted edge length {} of vertex {} is not positive", field.edge_length[v], v);
    mesh_edges(mesh.triangles, static_cast<int>(mesh.vertices.rows()));  // throws where it is no manifold
    return Remesher(mesh, triangle_labels, field).run();
}

}  // namespace ndg
