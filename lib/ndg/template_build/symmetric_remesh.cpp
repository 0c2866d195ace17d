// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/symmetric_remesh.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/adaptive_remesh.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/decimate.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/template_build/edge_length_field.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ndg {
namespace {

constexpr double asymmetry_limit = 0.005;  ///< m
constexpr double midline_snap = 1e-5;      ///< m; vertices this near to x = 0 are put onto it
/// Edges round a thin limb: 2 pi radius / 0.7 radius = 9.
constexpr double edge_per_radius = 0.7;
constexpr double least_share = 0.4;  ///< of the target edge length on thin limbs
constexpr double grading = 0.7;      ///< change of edge length with distance from a region's border
constexpr int loose_rings = 2;       ///< round vertices that a cut added, remeshed to take its slivers away
constexpr double shortest_target = 0.003, longest_target = 0.08;  ///< m

std::size_t index(Eigen::Index i)
{
    return static_cast<std::size_t>(i);
}

void check_symmetry(const Eigen::Ref<const Points>& vertices, const TriangleTree& tree)
{
    double worst = 0.0;
    Eigen::Index where = 0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        const double distance = tree.closest({-vertices(v, 0), vertices(v, 1), vertices(v, 2)}).distance;
        if (distance <= worst) continue;
        worst = distance;
        where = v;
    }
    require_input(
        worst <= asymmetry_limit,
        "the skin is not symmetric in x = 0: the mirror image of vertex {} at {:.3f} {:.3f} {:.3f} lies {:.1f} "
        "mm off it, allowed is {:.0f} mm",
        where, vertices(where, 0), vertices(where, 1), vertices(where, 2), 1e3 * worst, 1e3 * asymmetry_limit);
}

struct Half {
    TriangleMesh mesh;
    std::vector<int> regions;      ///< of triangles
    std::vector<char> from_a_cut;  ///< of vertices: added where a plane crosses an edge
};

/// The part with x > 0; its boundary is put onto x = 0 exactly.
Half left_half(const RegionCut& regions, Eigen::Index num_source_vertices)
{
    const Eigen::VectorXd field = -regions.vertices.col(0);
    const CutSurface cut = cut_along_zero(regions.vertices, regions.triangles, field, midline_snap);
    std::vector<char> on_plane(index(cut.vertices.rows()), 1);  // vertices added by the cut
    for (Eigen::Index v = 0; v < field.size(); ++v) on_plane[index(v)] = std::abs(field[v]) < midline_snap ? 1 : 0;
    Half half;
    std::vector<int> rows;
    for (Eigen::Index t = 0; t < cut.triangles.rows(); ++t) {
        if (cut.triangle_labels[index(t)] != 1) continue;
        // A triangle within the plane would meet its own mirror image.
        if (on_plane[index(cut.triangles(t, 0))] && on_plane[index(cut.triangles(t, 1))] &&
            on_plane[index(cut.triangles(t, 2))])
            continue;
        rows.push_back(static_cast<int>(t));
        half.regions.push_back(regions.regions[index(cut.triangle_parents[index(t)])]);
    }
    std::vector<int> new_of_old(index(cut.vertices.rows()), -1), kept;
    half.mesh.triangles.resize(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t row = 0; row < rows.size(); ++row)
        for (int k = 0; k < 3; ++k) {
            int& number = new_of_old[index(cut.triangles(rows[row], k))];
            if (number < 0) {
                number = static_cast<int>(kept.size());
                kept.push_back(cut.triangles(rows[row], k));
            }
            half.mesh.triangles(static_cast<Eigen::Index>(row), k) = number;
        }
    half.mesh.vertices = cut.vertices(kept, Eigen::all);
    for (const int v : kept) half.from_a_cut.push_back(v >= num_source_vertices ? 1 : 0);
    for (const auto& loop : boundary_loops(half.mesh.triangles, static_cast<int>(kept.size())))
        for (const int v : loop) half.mesh.vertices(v, 0) = 0.0;
    return half;
}

int mirrored_region(int region)
{
    std::string name = skin_region_names[index(region)];
    if (name.rfind("left_", 0) == 0) name = "right_" + name.substr(5);
    return static_cast<int>(std::find(skin_region_names.begin(), skin_region_names.end(), name) -
                            skin_region_names.begin());
}

/// Where head, hands or toes of the source intersect themselves (toes that lie in each other), vertices there are taken
/// away until they do not: what is left is coarser, but still on the source. Returns how many intersections stay.
std::size_t remove_intersections(LabelledMesh& half)
{
    constexpr int max_rounds = 60;
    std::size_t remaining = 0;
    for (int round = 0; round < max_rounds; ++round) {
        const auto pairs = self_intersections(half.mesh.vertices, half.mesh.triangles, true);
        remaining = pairs.size();
        if (pairs.empty()) break;
        std::vector<char> removable(index(half.mesh.vertices.rows()), 0);
        for (const auto& pair : pairs)
            for (const int t : {pair.first, pair.second})
                for (int k = 0; k < 3; ++k) removable[index(half.mesh.triangles(t, k))] = 1;
        const std::size_t before = half.triangle_labels.size();
        const std::size_t others =
            before - index(std::count(half.triangle_labels.begin(), half.triangle_labels.end(), 0));
        // A few at a time: one collapse takes two triangles away and may settle several intersections.
        const std::size_t step = 2 * (1 + pairs.size() / 8);
        half = decimate_labelled(half.mesh, half.triangle_labels, others > step ? others - step : 0, removable);
        if (half.triangle_labels.size() == before) break;
    }
    return remaining;
}

}  // namespace

struct SymmetricRemesher::State {
    TriangleMesh source;
    std::unique_ptr<TriangleTree> tree;  ///< of the source
    Half half;
    // At the vertices of the half:
    Eigen::VectorXd radius;         ///< of the limb, m
    Eigen::VectorXd source_length;  ///< of the source's edges, m
    std::vector<char> in_body;      ///< touches the body region
    EdgeDistance border;            ///< distance from the body region
    EdgeDistance cut;               ///< in rings, from vertices that a cut added

    RemeshField field(double target) const;
    LabelledMesh remesh_half(double target) const { return remesh_adaptively(half.mesh, half.regions, field(target)); }
};

RemeshField SymmetricRemesher::State::field(double target) const
{
    const Eigen::Index count = half.mesh.vertices.rows();
    RemeshField result{Eigen::VectorXd(count), std::vector<char>(index(count), 0)};
    const auto of_body = [&](Eigen::Index v) {
        return target * std::clamp(edge_per_radius * radius[v] / target, least_share, 1.0);
    };
    for (Eigen::Index v = 0; v < count; ++v) {
        if (in_body[index(v)]) {
            result.edge_length[v] = of_body(v);
            continue;
        }
        const double change = grading * border.distance[v];
        const double at_border = of_body(border.nearest[index(v)]);
        result.edge_length[v] = std::clamp(source_length[v], std::max(at_border - change, 1e-4), at_border + change);
        result.fixed[index(v)] = result.edge_length[v] == source_length[v] && cut.distance[v] > loose_rings ? 1 : 0;
    }
    return result;
}

SymmetricRemesher::SymmetricRemesher(const Eigen::Ref<const Points>& vertices,
                                     const Eigen::Ref<const Triangles>& triangles,
                                     const Eigen::Ref<const RowMatrix>& weights,
                                     const Eigen::Ref<const Points>& joint_positions)
{
    const std::string defect = closed_surface_defect(vertices, triangles);
    require_input(defect.empty(), "the skin cannot be remeshed: {}", defect);
    auto state = std::make_unique<State>();
    state->source = {vertices, triangles};
    state->tree = std::make_unique<TriangleTree>(vertices, triangles);
    check_symmetry(vertices, *state->tree);
    state->half = left_half(cut_regions(vertices, triangles, weights, joint_positions), vertices.rows());

    const TriangleMesh& half = state->half.mesh;
    constexpr double trunk_radius = 1.0;  // more than any target asks for
    const Eigen::VectorXd radius = limb_radius(vertices, weights, joint_positions, trunk_radius);
    const Eigen::VectorXd length = mean_edge_length(vertices, triangles);
    state->radius.setZero(half.vertices.rows());
    state->source_length.setZero(half.vertices.rows());
    std::vector<int> added;
    for (Eigen::Index v = 0; v < half.vertices.rows(); ++v) {
        const ClosestPoint closest = state->tree->closest(half.vertices.row(v).transpose());
        for (int k = 0; k < 3; ++k) {
            const int corner = triangles(closest.triangle_idx, k);
            state->radius[v] += closest.barycentric[k] * radius[corner];
            state->source_length[v] += closest.barycentric[k] * length[corner];
        }
        if (state->half.from_a_cut[index(v)]) added.push_back(static_cast<int>(v));
    }
    state->in_body.assign(index(half.vertices.rows()), 0);
    for (Eigen::Index t = 0; t < half.triangles.rows(); ++t)
        if (state->half.regions[index(t)] == 0)
            for (int k = 0; k < 3; ++k) state->in_body[index(half.triangles(t, k))] = 1;
    std::vector<int> body;
    for (std::size_t v = 0; v < state->in_body.size(); ++v)
        if (state->in_body[v]) body.push_back(static_cast<int>(v));
    state->border = distance_along_edges(half.vertices, half.triangles, body);

    // Rings are counted, so every edge is one long there.
    state->cut.distance.setConstant(half.vertices.rows(), 1e9);
    const auto neighbours = vertex_neighbours(half.triangles, static_cast<int>(half.vertices.rows()));
    for (const int v : added) state->cut.distance[v] = 0.0;
    for (int ring = 1; ring <= loose_rings; ++ring) {
        std::vector<int> next;
        for (const int v : added)
            for (const int other : neighbours[index(v)])
                if (state->cut.distance[other] > ring) {
                    state->cut.distance[other] = ring;
                    next.push_back(other);
                }
        added = next;
    }
    state_ = std::move(state);
}

SymmetricRemesher::~SymmetricRemesher() = default;
SymmetricRemesher::SymmetricRemesher(SymmetricRemesher&&) noexcept = default;

RemeshedSkin SymmetricRemesher::remesh(double target_edge_length, double keep_ratio) const
{
    require_input(target_edge_length >= shortest_target && target_edge_length <= longest_target,
                  "the target edge length is {} m, allowed is {} to {}", target_edge_length, shortest_target,
                  longest_target);
    require_input(keep_ratio > 0.0 && keep_ratio <= 1.0, "the keep ratio {} is not in (0, 1]", keep_ratio);
    const auto others =
        state_->half.regions.size() - index(std::count(state_->half.regions.begin(), state_->half.regions.end(), 0));
    LabelledMesh half = state_->remesh_half(target_edge_length);
    half = decimate_labelled(half.mesh, half.triangle_labels,
                             static_cast<std::size_t>(std::llround(keep_ratio * static_cast<double>(others))));

    const std::size_t intersections = remove_intersections(half);
    if (intersections > 0) log_warning("the remeshed skin intersects itself in {} places on each side", intersections);

    const Points& left = half.mesh.vertices;
    RemeshedSkin skin;
    std::vector<int> right_of_left(index(left.rows()), -1);
    for (const auto& loop : boundary_loops(half.mesh.triangles, static_cast<int>(left.rows())))
        for (const int v : loop) right_of_left[index(v)] = v;
    skin.vertices = left;
    skin.mirror = right_of_left;
    int count = static_cast<int>(left.rows());
    skin.vertices.conservativeResize(2 * left.rows(), 3);
    for (Eigen::Index v = 0; v < left.rows(); ++v) {
        int& right = right_of_left[index(v)];
        if (right >= 0) continue;
        right = count++;
        skin.mirror[index(v)] = right;
        skin.mirror.push_back(static_cast<int>(v));
        const Eigen::Vector3d mirrored(-left(v, 0), left(v, 1), left(v, 2));
        const ClosestPoint closest = state_->tree->closest(mirrored);
        constexpr double rounding = 1e-9;
        skin.vertices.row(right) = (closest.distance > rounding ? closest.point : mirrored).transpose();
    }
    skin.vertices.conservativeResize(count, 3);

    const Eigen::Index half_triangles = half.mesh.triangles.rows();
    skin.triangles.resize(2 * half_triangles, 3);
    skin.triangles.topRows(half_triangles) = half.mesh.triangles;
    skin.regions = half.triangle_labels;
    for (Eigen::Index t = 0; t < half_triangles; ++t) {
        for (int k = 0; k < 3; ++k)  // the other way round
            skin.triangles(half_triangles + t, k) = right_of_left[index(half.mesh.triangles(t, 2 - k))];
        skin.regions.push_back(mirrored_region(half.triangle_labels[index(t)]));
    }
    const std::string defect = closed_surface_defect(skin.vertices, skin.triangles);
    require(defect.empty(), "remeshing to edges of {} m broke the surface ({})", target_edge_length, defect);
    return skin;
}

double SymmetricRemesher::edge_length_for_prisms(int num_prisms) const
{
    require_input(num_prisms > 0, "the wanted number of prisms {} is not positive", num_prisms);
    // The number jumps by a percent or so under small changes of the length: after some attempts the best one will do.
    constexpr double aim = 0.01, tolerance = 0.03;
    constexpr int max_attempts = 6;
    double best_target = 0.0, best_error = tolerance;
    // First guess: equilateral triangles of the field's size cover the area.
    const Eigen::VectorXd areas = triangle_areas(state_->half.mesh.vertices, state_->half.mesh.triangles);
    const auto expected_prisms = [&](double target) {
        const RemeshField field = state_->field(target);
        double triangles = 0.0;
        for (Eigen::Index t = 0; t < areas.size(); ++t) {
            if (state_->half.regions[index(t)] != 0) continue;
            double size = 0.0;
            for (int k = 0; k < 3; ++k) size += field.edge_length[state_->half.mesh.triangles(t, k)] / 3.0;
            triangles += areas[t] / (std::sqrt(3.0) / 4.0 * size * size);
        }
        return 4.0 * triangles;  // both halves, two prisms each
    };
    double wanted_of_guess = num_prisms, last_target = 0.0;
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
        double low = shortest_target, high = longest_target;
        for (int step = 0; step < 60; ++step) {
            const double middle = std::sqrt(low * high);
            (expected_prisms(middle) > wanted_of_guess ? low : high) = middle;
        }
        const double target = std::sqrt(low * high);
        if (target == last_target) break;  // at the end of the range
        last_target = target;
        const LabelledMesh half = state_->remesh_half(target);
        const double reached =
            4.0 * static_cast<double>(std::count(half.triangle_labels.begin(), half.triangle_labels.end(), 0));
        const double error = std::abs(reached / num_prisms - 1.0);
        if (error <= aim) return target;
        if (error <= best_error) {
            best_error = error;
            best_target = target;
        }
        wanted_of_guess *= num_prisms / reached;
    }
    if (best_target > 0.0) return best_target;
    throw InputError(
        fmt::format("no edge length between {} and {} m gives {} prisms", shortest_target, longest_target, num_prisms));
}

int RemeshedSkin::num_body_triangles() const
{
    return static_cast<int>(std::count(regions.begin(), regions.end(), 0));
}

RemeshedSkin remesh_symmetric(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                              const Eigen::Ref<const RowMatrix>& weights,
                              const Eigen::Ref<const Points>& joint_positions, double target_edge_length,
                              double keep_ratio)
{
    return SymmetricRemesher(vertices, triangles, weights, joint_positions).remesh(target_edge_length, keep_ratio);
}

double edge_length_for_prisms(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                              const Eigen::Ref<const RowMatrix>& weights,
                              const Eigen::Ref<const Points>& joint_positions, int num_prisms)
{
    return SymmetricRemesher(vertices, triangles, weights, joint_positions).edge_length_for_prisms(num_prisms);
}

}  // namespace ndg
