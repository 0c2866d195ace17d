// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/anatomy_wraps.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/prism.h"
#include "ndg/wraps/bone_interior.h"
#include "ndg/wraps/envelope.h"
#include "ndg/wraps/wrap_optimiser.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

namespace ndg {
namespace {

constexpr double first_repulsion = 100.0, last_repulsion = 1000.0;
constexpr int first_iterations = 100, refine_iterations = 40, max_refinements = 8;
constexpr double max_extra_margin = 0.002;                    ///< m
constexpr double max_spacing = 0.0035, min_spacing = 0.0025;  ///< m, of the envelope's grid

double mean_edge(const WrapSkin& skin)
{
    double sum = 0.0;
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k)
            sum += (skin.vertices.row(skin.triangles(t, k)) - skin.vertices.row(skin.triangles(t, (k + 1) % 3))).norm();
    return sum / (3.0 * static_cast<double>(skin.triangles.rows()));
}

/// Vertices of one layer's parts that lie inside the closed skin.
struct Contents {
    Points points;
    std::vector<std::string> names;
};

Contents contents(const WrapSkin& skin, const std::vector<AnatomyMesh>& anatomy, bool with_muscles)
{
    const ClosedBoneWrap closed = close_bone_wrap(skin.vertices, skin.triangles);
    const TriangleTree tree(closed.vertices, closed.triangles);
    const Eigen::RowVector3d low = skin.vertices.colwise().minCoeff(), high = skin.vertices.colwise().maxCoeff();
    Contents result;
    std::vector<Eigen::RowVector3d> points;
    for (const AnatomyMesh& part : anatomy) {
        if (part.layer != AnatomyLayer::bone && !with_muscles) continue;
        std::vector<char> inside(part.vertices.rows(), 0);
#pragma omp parallel for schedule(static)
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v) {
            const Eigen::RowVector3d point = part.vertices.row(v);
            const bool in_box = (point.array() >= low.array()).all() && (point.array() <= high.array()).all();
            inside[v] = in_box && tree.signed_distance(point.transpose()) < 0.0;
        }
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v) {
            if (!inside[v]) continue;
            points.emplace_back(part.vertices.row(v));
            result.names.push_back(part.name);
        }
    }
    result.points.resize(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t v = 0; v < points.size(); ++v) result.points.row(static_cast<Eigen::Index>(v)) = points[v];
    return result;
}

struct Containment {
    Eigen::Index outside = 0, total = 0;
    double worst = 0.0;  ///< m outside of the wrap
    std::string worst_part;

    double percent() const
    {
        return total == 0 ? 100.0 : 100.0 * static_cast<double>(total - outside) / static_cast<double>(total);
    }
};

/// How much of the contents is outside of a wrap. `margins` (one for each triangle) grow where contents come nearer
/// than a third of `wanted`. Vertices beside a cap are not the wrap's business.
Containment check_containment(const WrapSkin& skin, const Points& wrap, const Contents& inside, double wanted,
                              Eigen::Ref<Eigen::ArrayXd> margins)
{
    const ClosedBoneWrap closed = close_bone_wrap(wrap, skin.triangles);
    const TriangleTree tree(closed.vertices, closed.triangles);
    const Eigen::Index count = inside.points.rows();
    Eigen::VectorXd distances(count);
    std::vector<int> triangles(count);
#pragma omp parallel for schedule(dynamic, 256)
    for (Eigen::Index p = 0; p < count; ++p) {
        ClosestPoint nearest;
        distances[p] = tree.signed_distance(inside.points.row(p).transpose(), &nearest);
        triangles[p] = nearest.triangle_idx;
    }
    Containment result;
    Eigen::ArrayXd lack = Eigen::ArrayXd::Zero(margins.size());
    for (Eigen::Index p = 0; p < count; ++p) {
        const int t = triangles[p];
        if (t >= skin.triangles.rows()) continue;
        ++result.total;
        lack[t] = std::max(lack[t], distances[p] + wanted / 3.0);
        if (distances[p] <= 0.0) continue;
        ++result.outside;
        if (distances[p] <= result.worst) continue;
        result.worst = distances[p];
        result.worst_part = inside.names[p];
    }
    // Anatomy far outside is the energy's business, not the margin's.
    margins = (margins + 1.2 * lack.min(0.001)).min(wanted + max_extra_margin);
    return result;
}

struct PrismReport {
    double jacobian = std::numeric_limits<double>::max();
    Eigen::Index triangle = 0;
};

/// Worst prism of both layers as it will be stored, in single precision.
PrismReport worst_prism(const WrapSkin& skin, const WrapPair& wraps)
{
    PrismReport report;
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int layer = 0; layer < 2; ++layer) {
            PrismVertices prism;
            for (int k = 0; k < 3; ++k) {
                const int v = skin.triangles(t, k);
                prism.row(k) = layer == 0 ? skin.vertices.row(v) : wraps.muscle.row(v);
                prism.row(3 + k) = layer == 0 ? wraps.muscle.row(v) : wraps.bone.row(v);
            }
            const double quality = prism_min_scaled_jacobian(prism.cast<float>().cast<double>());
            if (quality >= report.jacobian) continue;
            report = {quality, t};
        }
    return report;
}

/// Intersecting pairs of triangles among bone wrap, muscle wrap and skin; indices run through them in that order.
std::vector<std::pair<int, int>> intersections(const WrapSkin& skin, const WrapPair& wraps)
{
    const Eigen::Index count = skin.vertices.rows(), num_triangles = skin.triangles.rows();
    Points vertices(3 * count, 3);
    vertices << wraps.bone, wraps.muscle, skin.vertices;
    Triangles triangles(3 * num_triangles, 3);
    for (int layer = 0; layer < 3; ++layer)
        triangles.middleRows(layer * num_triangles, num_triangles) =
            skin.triangles.array() + layer * static_cast<int>(count);
    auto pairs = self_intersections(vertices.cast<float>().cast<double>(), triangles, true);
    // Where the skin meets itself, that is none of the wraps' doing.
    const int first_skin = static_cast<int>(2 * num_triangles);
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [&](const auto& pair) { return pair.first >= first_skin; }),
                pairs.end());
    return pairs;
}

}  // namespace

void describe(OptionList& list, AnatomyWrapOptions& options)
{
    list.add("min-scaled-jacobian", options.min_scaled_jacobian, "no prism flatter than this is wanted", 0.001, 0.5);
    list.add("bone-margin", options.bone_margin, "m", 0, 0.02).no_flag();
    list.add("muscle-margin", options.muscle_margin, "m", 0, 0.02).no_flag();
    list.add("min-thickness", options.min_thickness, "m", 0.0001, 0.02).no_flag();
}

Wraps anatomy_wraps(const WrapSkin& skin, const std::vector<AnatomyMesh>& anatomy, const AnatomyWrapOptions& options)
{
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    const double edge = mean_edge(skin);
    EnvelopeOptions envelope_options;
    envelope_options.spacing = std::clamp(0.25 * edge, min_spacing, max_spacing);
    envelope_options.min_thickness = options.min_thickness;
    const WrapEnvelopes envelopes = wrap_envelopes(skin, anatomy, envelope_options);
    log_debug("wraps: envelopes on {} x {} x {} nodes after {:.1f} s", envelopes.bone.box.size[0],
              envelopes.bone.box.size[1], envelopes.bone.box.size[2], seconds());

    WrapEnergyOptions energy_options;
    energy_options.bone_bending_length = 0.006 + 0.5 * edge;
    energy_options.muscle_bending_length = 0.003 + 0.4 * edge;
    energy_options.cover = options.min_thickness;
    energy_options.repulsion = first_repulsion;
    WrapEnergy energy(skin, envelopes.bone, envelopes.muscle, envelopes.skin, energy_options);
    energy.margins.col(0) = options.bone_margin;
    energy.margins.col(1) = options.muscle_margin;
    WrapTargets targets;
    targets.min_scaled_jacobian = 1.06 * options.min_scaled_jacobian;
    targets.min_thickness = options.min_thickness;
    WrapOptimiser optimiser(skin, energy, targets, "wraps");
    int iterations = optimiser.flow(first_iterations, 3e-2);
    log_debug("wraps: first flow after {} iterations, {:.1f} s", iterations, seconds());

    const Contents bones = contents(skin, anatomy, false), all = contents(skin, anatomy, true);
    Containment bone_report, muscle_report;
    PrismReport prisms;
    std::vector<std::pair<int, int>> pairs;
    Eigen::Index outside_before = std::numeric_limits<Eigen::Index>::max();
    double worst_before = std::numeric_limits<double>::max();
    int idle_rounds = 0;
    for (int refinement = 0; refinement <= max_refinements; ++refinement) {
        bone_report =
            check_containment(skin, optimiser.wraps().bone, bones, options.bone_margin, energy.margins.col(0));
        muscle_report =
            check_containment(skin, optimiser.wraps().muscle, all, options.muscle_margin, energy.margins.col(1));
        prisms = worst_prism(skin, optimiser.wraps());
        pairs = intersections(skin, optimiser.wraps());
        log_debug(
            "wraps: {} iterations, {:.1f} s: scaled Jacobian {:.4f}, bones {:.3f} % ({:.2f} mm, {}), muscles {:.3f} % "
            "({:.2f} mm, {}), {} intersections",
            iterations, seconds(), prisms.jacobian, bone_report.percent(), 1e3 * bone_report.worst,
            bone_report.worst_part, muscle_report.percent(), 1e3 * muscle_report.worst, muscle_report.worst_part,
            pairs.size());
        const bool done = prisms.jacobian >= options.min_scaled_jacobian && bone_report.outside == 0 &&
                          muscle_report.outside == 0 && pairs.empty();
        // The last few may be out of reach (a bone that all but touches the skin): no use in trying for ever.
        const Eigen::Index outside = bone_report.outside + muscle_report.outside;
        const double worst = bone_report.worst + muscle_report.worst;
        const bool better = outside < outside_before || worst < 0.9 * worst_before;
        idle_rounds = better ? 0 : idle_rounds + 1;
        outside_before = std::min(outside, outside_before);
        worst_before = std::min(worst, worst_before);
        const bool stuck = idle_rounds >= 2 && pairs.empty();
        if (done || stuck || refinement == max_refinements) break;
        energy.options.repulsion = std::min(last_repulsion, 3.0 * energy.options.repulsion);
        iterations += optimiser.flow(refine_iterations, 5e-3);
    }

    const Eigen::RowVector3d place = skin.vertices.row(skin.triangles(prisms.triangle, 0));
    require(prisms.jacobian > 0.05,
            "the wraps' worst prism, near ({:.3f}, {:.3f}, {:.3f}) m, has a scaled Jacobian of {:.3g}", place[0],
            place[1], place[2], prisms.jacobian);
    if (!pairs.empty()) {
        const Eigen::Index t = pairs.front().first % skin.triangles.rows();
        const Eigen::RowVector3d where = skin.vertices.row(skin.triangles(t, 0));
        const char* const names[] = {"bone wrap", "muscle wrap", "skin"};
        throw Error(fmt::format(
            "{} pairs of triangles of the wraps intersect, the first of {} and {} near ({:.3f}, {:.3f}, {:.3f}) m",
            pairs.size(), names[pairs.front().first / skin.triangles.rows()],
            names[pairs.front().second / skin.triangles.rows()], where[0], where[1], where[2]));
    }
    require(bone_report.percent() >= 99.9,
            "only {:.2f} % of the bones lie inside the bone wrap; {} sticks out by {:.2f} mm", bone_report.percent(),
            bone_report.worst_part, 1e3 * bone_report.worst);
    require(muscle_report.percent() >= 99.9,
            "only {:.2f} % of bones and muscles lie inside the muscle wrap; {} sticks out by {:.2f} mm",
            muscle_report.percent(), muscle_report.worst_part, 1e3 * muscle_report.worst);
    log_info(
        "wraps: smallest scaled Jacobian {:.3f}; bones inside {:.3f} %, worst {:.2f} mm; muscles inside {:.3f} %, "
        "worst "
        "{:.2f} mm; no intersections; {} iterations, {:.0f} s",
        prisms.jacobian, bone_report.percent(), 1e3 * bone_report.worst, muscle_report.percent(),
        1e3 * muscle_report.worst, iterations, seconds());

    Wraps wraps;
    wraps.bone = optimiser.wraps().bone;
    wraps.muscle = optimiser.wraps().muscle;
    wraps.min_scaled_jacobian = prisms.jacobian;
    return wraps;
}

}  // namespace ndg
