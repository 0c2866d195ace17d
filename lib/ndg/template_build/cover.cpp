// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/cover.h"

#include "ndg/body_source/displacement_field.h"
#include "ndg/body_source/skin_depth.h"
#include "ndg/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace ndg {
namespace {

/// Spacings of the grids, m, and rounds on each.
constexpr std::array<double, 3> spacings = {0.032, 0.016, 0.008};
constexpr std::array<int, 3> rounds = {3, 3, 1};
/// Vertices with enough cover hold still with this weight against one for those without.
constexpr double still_weight = 0.03;
/// Asked for beyond the cover, so that smoothing does not leave most vertices just short of it.
constexpr double surplus = 0.0004;
constexpr int compression_rounds = 12;
/// Rounds in which violations reach out; later ones mend single vertices, or their surroundings would be pressed flat.
constexpr int shared_rounds = 2;
/// Violations reach out to what lies around them within this distance, m, or six times their size.
constexpr double compression_reach = 0.012;

/// All parts as one point set.
struct PointSet {
    Points positions;
    std::vector<int> part_of;
    std::vector<char> is_bone, hollow;
};

PointSet gather(const std::vector<AnatomyMesh>& anatomy)
{
    PointSet set;
    set.positions = join_meshes(anatomy).vertices;
    for (std::size_t i = 0; i < anatomy.size(); ++i) {
        const AnatomyMesh& part = anatomy[i];
        const auto rows = std::size_t(part.vertices.rows());
        set.part_of.insert(set.part_of.end(), rows, int(i));
        set.is_bone.insert(set.is_bone.end(), rows, part.layer == AnatomyLayer::bone);
        set.hollow.insert(set.hollow.end(), rows, part.joint != "head" && part.joint != "jaw");
    }
    return set;
}

/// Depth of every point, and what it is asked for. Points that were deep are asked for again only once they have moved
/// so far that they may lack cover.
class DepthTable {
public:
    DepthTable(const SkinDepth& skin, const PointSet& points, const CoverOptions& options)
        : skin_(skin),
          points_(points),
          options_(options),
          results_(points.part_of.size()),
          wanted_(points.part_of.size()),
          slack_(points.part_of.size(), -1e9),
          reach_(points.part_of.size(), -1.0),
          asked_(points.positions)
    {
    }

    void update(double reach)
    {
#pragma omp parallel for schedule(dynamic, 256)
        for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(results_.size()); ++i) {
            const auto k = std::size_t(i);
            const Eigen::Vector3d point = points_.positions.row(i).transpose();
            const double moved = (points_.positions.row(i) - asked_.row(i)).norm();
            if (slack_[k] > reach + moved || (moved == 0.0 && reach <= reach_[k])) continue;
            reach_[k] = reach;
            const bool hollow = points_.hollow[k] != 0;
            const double cover = points_.is_bone[k] ? options_.bone : options_.muscle;
            results_[k] = skin_.at(point, hollow);
            wanted_[k] = results_[k].depth < cover + reach ? skin_.cover_at(results_[k], cover, hollow) : cover;
            slack_[k] = results_[k].depth - cover;
            asked_.row(i) = points_.positions.row(i);
        }
    }

    const SkinDepth::Result& result(std::size_t i) const
    {
        return results_[i];
    }
    double wanted(std::size_t i) const
    {
        return wanted_[i];
    }
    double missing(std::size_t i) const
    {
        return std::max(0.0, wanted_[i] - results_[i].depth);
    }
    /// Missing cover with the surplus, zero for points far from lacking any.
    double push(std::size_t i) const
    {
        return std::max(0.0, wanted_[i] + surplus - results_[i].depth);
    }
    double room(std::size_t i, double reach) const
    {
        return skin_.room_at(results_[i], reach, points_.hollow[i] != 0);
    }
    double full_cover(std::size_t i) const
    {
        return points_.is_bone[i] ? options_.bone : options_.muscle;
    }

private:
    const SkinDepth& skin_;
    const PointSet& points_;
    CoverOptions options_;
    std::vector<SkinDepth::Result> results_;
    std::vector<double> wanted_, slack_, reach_;
    Points asked_;
};

void push_smoothly(PointSet& points, DepthTable& table)
{
    const Eigen::Index count = points.positions.rows();
    for (std::size_t level = 0; level < spacings.size(); ++level) {
        const double spacing = spacings[level];
        for (int round = 0; round < rounds[level]; ++round) {
            table.update(0.5 * spacing);
            Points displacements = Points::Zero(count, 3);
            Eigen::VectorXd weights = Eigen::VectorXd::Constant(count, still_weight);
            double worst = 0.0;
            for (Eigen::Index i = 0; i < count; ++i) {
                const double push = table.push(std::size_t(i));
                if (push <= 0.0) continue;
                displacements.row(i) = push * table.result(std::size_t(i)).inward.transpose();
                weights[i] = 1.0;
                worst = std::max(worst, table.missing(std::size_t(i)));
            }
            if (worst <= 0.0) return;
            const DisplacementField field(points.positions, displacements, weights, spacing, {});
            points.positions += field.at(points.positions);
        }
    }
}

/// Largest missing cover around each point, fading with distance: a cone over every violation. Only points near the
/// skin are asked for.
Eigen::VectorXd violation_envelope(const PointSet& points, const DepthTable& table)
{
    using Cell = std::array<int, 3>;
    struct Violation {
        Eigen::RowVector3d position;
        double size, reach;
    };
    std::map<Cell, std::vector<Violation>> cells;
    double longest = compression_reach;
    for (Eigen::Index i = 0; i < points.positions.rows(); ++i)
        longest = std::max(longest, 6.0 * table.missing(std::size_t(i)));
    const auto cell_of = [&](const Eigen::RowVector3d& p) {
        return Cell{int(std::floor(p[0] / longest)), int(std::floor(p[1] / longest)), int(std::floor(p[2] / longest))};
    };
    for (Eigen::Index i = 0; i < points.positions.rows(); ++i) {
        const double missing = table.missing(std::size_t(i));
        if (missing > 0.0)
            cells[cell_of(points.positions.row(i))].push_back(
                {points.positions.row(i), missing, std::max(compression_reach, 6.0 * missing)});
    }
    Eigen::VectorXd envelope = Eigen::VectorXd::Zero(points.positions.rows());
    if (cells.empty()) return envelope;
#pragma omp parallel for schedule(dynamic, 256)
    for (Eigen::Index i = 0; i < points.positions.rows(); ++i) {
        if (table.result(std::size_t(i)).depth > table.full_cover(std::size_t(i)) + longest) continue;
        const Cell cell = cell_of(points.positions.row(i));
        for (int k = 0; k < 27; ++k) {
            const auto found = cells.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
            if (found == cells.end()) continue;
            for (const Violation& violation : found->second) {
                const double distance = (points.positions.row(i) - violation.position).norm();
                envelope[i] = std::max(envelope[i], violation.size * (1.0 - distance / violation.reach));
            }
        }
    }
    return envelope;
}

Eigen::VectorXd violations(const PointSet& points, const DepthTable& table)
{
    Eigen::VectorXd missing(points.positions.rows());
    for (Eigen::Index i = 0; i < missing.size(); ++i) missing[i] = table.missing(std::size_t(i));
    return missing;
}

/// Depths from wanted - h to `top` go to wanted to `top`, linearly, so that nothing passes anything else; `top` is
/// wanted + 2 h, or the middle of the body where that is nearer.
void compress(PointSet& points, DepthTable& table)
{
    for (int round = 0; round < compression_rounds; ++round) {
        table.update(compression_reach);
        const Eigen::VectorXd envelope =
            round < shared_rounds ? violation_envelope(points, table) : violations(points, table);
        if (envelope.size() == 0 || envelope.maxCoeff() <= 0.0) return;
#pragma omp parallel for schedule(dynamic, 256)
        for (Eigen::Index i = 0; i < points.positions.rows(); ++i) {
            if (envelope[i] <= 0.0) continue;
            const double h = envelope[i] + 0.1 * surplus;
            const SkinDepth::Result& at = table.result(std::size_t(i));
            const double wanted = table.wanted(std::size_t(i)), over = at.depth - wanted;
            if (over >= 2.0 * h) continue;
            const double room = table.room(std::size_t(i), wanted + 2.0 * h) - wanted;
            const double top = std::clamp(room, 0.1 * wanted, 2.0 * h);
            if (over >= top) continue;
            const double moved = (over + h) * top / (top + h) - over;
            points.positions.row(i) += std::max(0.0, moved) * at.inward.transpose();
        }
    }
    table.update(compression_reach);
}

}  // namespace

void describe(OptionList& list, CoverOptions& options)
{
    list.add("bone-cover", options.bone, "least depth of bones under the skin, m", 0.0001, 0.02);
    list.add("muscle-cover", options.muscle, "least depth of muscles under the skin, m", 0.0001, 0.02);
}

CoverReport cover_with_skin(const Eigen::Ref<const Points>& skin_vertices,
                            const Eigen::Ref<const Triangles>& skin_triangles, std::vector<AnatomyMesh>& anatomy,
                            const CoverOptions& options)
{
    check_options(options);
    CoverReport report;
    if (anatomy.empty()) return report;
    const SkinDepth skin(skin_vertices, skin_triangles);
    PointSet points = gather(anatomy);
    const Points before = points.positions;
    DepthTable table(skin, points, options);
    constexpr double far_away = std::numeric_limits<double>::max();
    const auto smallest = [&](bool bone, bool full_only, int& worst) {
        double depth = far_away;
        for (std::size_t i = 0; i < points.part_of.size(); ++i) {
            if ((points.is_bone[i] != 0) != bone) continue;
            if (full_only && table.wanted(i) < table.full_cover(i)) continue;
            if (table.result(i).depth >= depth) continue;
            depth = table.result(i).depth;
            worst = points.part_of[i];
        }
        return depth == far_away ? 0.0 : depth;
    };
    table.update(spacings.front());
    int worst_bone = -1, worst_muscle = -1;
    report.min_bone_before = smallest(true, false, worst_bone);
    report.min_muscle_before = smallest(false, false, worst_muscle);
    push_smoothly(points, table);
    compress(points, table);

    worst_bone = worst_muscle = -1;
    report.min_bone = smallest(true, true, worst_bone);
    report.min_muscle = smallest(false, true, worst_muscle);
    if (worst_bone >= 0) report.worst_bone = anatomy[std::size_t(worst_bone)].name;
    if (worst_muscle >= 0) report.worst_muscle = anatomy[std::size_t(worst_muscle)].name;
    report.min_thin = far_away;
    for (std::size_t i = 0; i < points.part_of.size(); ++i) {
        require(table.result(i).depth > 0.0, "'{}' cannot be brought inside the skin, {:.2f} mm of it stay outside",
                anatomy[std::size_t(points.part_of[i])].name, -1e3 * table.result(i).depth);
        if (table.wanted(i) < table.full_cover(i)) {
            ++report.thin_vertices;
            report.min_thin = std::min(report.min_thin, table.result(i).depth);
        }
    }
    if (report.thin_vertices == 0) report.min_thin = 0.0;
    const Eigen::VectorXd moved = (points.positions - before).rowwise().norm();
    report.moved_vertices = int((moved.array() > 1e-4).count());
    report.max_displacement = moved.maxCoeff();
    take_joined_vertices(points.positions, anatomy);
    return report;
}

}  // namespace ndg
