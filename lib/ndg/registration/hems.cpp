// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/hems.h"

#include "ndg/body/skeleton.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace ndg {
namespace {

constexpr int num_sectors = 8, min_sectors = 6;
constexpr std::size_t min_points = 4;  ///< of a sector on one side
/// Along the limb, m: places that are tried, and what is compared on either side of them.
constexpr double place_step = 0.01, gap = 0.004, window = 0.03;
constexpr double least_step = 0.007, least_sector_step = 0.003, sector_share = 0.75;
/// Not at the joints, where creases are: shares of the two bones together.
constexpr double first_place = 0.12, last_place = 0.97;
/// Clothes lie this near to the skin, m, those inside it this deep at most.
constexpr double max_outside = 0.08, max_inside = 0.03;

/// Two bones of a limb: place along them and sector around them.
struct Limb {
    std::array<SkinSegment, 2> segments;
    Eigen::Vector3d begin, middle, end;
    double upper() const { return (middle - begin).norm(); }
    double length() const { return upper() + (end - middle).norm(); }
    double along(const Eigen::Vector3d& point, int bone) const
    {
        const Eigen::Vector3d& origin = bone == 0 ? begin : middle;
        const Eigen::Vector3d direction = ((bone == 0 ? middle : end) - origin).normalized();
        return (bone == 0 ? 0.0 : upper()) + (point - origin).dot(direction);
    }
    int sector(const Eigen::Vector3d& point, int bone) const
    {
        const Eigen::Vector3d& origin = bone == 0 ? begin : middle;
        const Eigen::Vector3d direction = ((bone == 0 ? middle : end) - origin).normalized();
        const Eigen::Vector3d front = (Eigen::Vector3d::UnitZ() - direction[2] * direction).normalized();
        const Eigen::Vector3d offset = point - origin;
        const double angle = std::atan2(offset.dot(direction.cross(front)), offset.dot(front));
        return std::clamp(static_cast<int>((angle / EIGEN_PI + 1.0) * 0.5 * num_sectors), 0, num_sectors - 1);
    }
};

struct Sample {
    double along, outside;
    int sector;
};

double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

struct Hem {
    double along = 0.0;
    double step = 0.0;  ///< m, positive where the limb's far side is the thicker one; 0: none
};

Hem find_hem(const std::vector<Sample>& samples, double length)
{
    Hem best;
    for (double place = first_place * length; place < last_place * length; place += place_step) {
        std::array<std::vector<double>, num_sectors> before, behind;
        for (const Sample& sample : samples) {
            const double distance = sample.along - place;
            if (std::abs(distance) < gap || std::abs(distance) > window) continue;
            (distance < 0 ? before : behind)[sample.sector].push_back(sample.outside);
        }
        std::vector<double> steps;
        for (int s = 0; s < num_sectors; ++s) {
            if (before[s].size() < min_points || behind[s].size() < min_points) continue;
            steps.push_back(median(behind[s]) - median(before[s]));
        }
        if (steps.size() < min_sectors) continue;
        const double step = median(steps);
        const auto agreeing = std::count_if(steps.begin(), steps.end(), [&](double value) {
            return value * step > 0 && std::abs(value) > least_sector_step;
        });
        if (static_cast<double>(agreeing) < sector_share * static_cast<double>(steps.size())) continue;
        if (std::abs(step) > std::max(least_step, std::abs(best.step))) best = {place, step};
    }
    return best;
}

}  // namespace

HemCover find_hems(const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed, const ScanTarget& scan, bool arms)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto joint = [&](const std::string& name) -> Eigen::Vector3d {
        return rest.joint_positions.row(skeleton.joint(name)).transpose();
    };
    std::vector<Limb> limbs;
    for (const std::string side : {"left_", "right_"}) {
        const bool left = side == "left_";
        limbs.push_back({{left ? SkinSegment::left_thigh : SkinSegment::right_thigh,
                          left ? SkinSegment::left_shin : SkinSegment::right_shin},
                         joint(side + "thigh"),
                         joint(side + "shin"),
                         joint(side + "foot")});
        limbs.push_back({{left ? SkinSegment::left_upper_arm : SkinSegment::right_upper_arm,
                          left ? SkinSegment::left_forearm : SkinSegment::right_forearm},
                         joint(side + "upper_arm"),
                         joint(side + "forearm"),
                         joint(side + "hand")});
    }
    const std::vector<SkinSegment> segments = skin_segments(rest.weights);
    const auto bone_of = [&](const Limb& limb, int vertex) {
        return segments[vertex] == limb.segments[0] ? 0 : segments[vertex] == limb.segments[1] ? 1 : -1;
    };

    // Places of the scan's points at rest, and how far outside they lie.
    const TriangleTree tree(posed, rest.triangles);
    const Points normals = vertex_normals(posed, rest.triangles);
    std::vector<std::vector<Sample>> samples(limbs.size());
    for (Eigen::Index i = 0; i < scan.points.rows(); ++i) {
        const Eigen::Vector3d point = scan.points.row(i).transpose();
        const ClosestPoint closest = tree.closest(point);
        const Eigen::Vector3i corners = rest.triangles.row(closest.triangle_idx).transpose();
        Eigen::Index corner = 0;
        closest.barycentric.maxCoeff(&corner);
        Eigen::Vector3d normal = Eigen::Vector3d::Zero(), place = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            normal += closest.barycentric[k] * normals.row(corners[k]).transpose();
            place += closest.barycentric[k] * rest.vertices.row(corners[k]).transpose();
        }
        const double outside = (point - closest.point).dot(normal.normalized());
        if (outside > max_outside || outside < -max_inside) continue;
        for (std::size_t l = 0; l < limbs.size(); ++l) {
            const int bone = bone_of(limbs[l], corners[corner]);
            if (bone >= 0) samples[l].push_back({limbs[l].along(place, bone), outside, limbs[l].sector(place, bone)});
        }
    }

    HemCover result;
    result.covered.assign(segments.size(), 0);
    const auto dress = [&](SegmentPair pair) { result.dressed[static_cast<std::size_t>(pair)] = true; };
    std::vector<Hem> hems;
    for (std::size_t l = 0; l < limbs.size(); ++l) hems.push_back(find_hem(samples[l], limbs[l].length()));
    for (std::size_t l = 0; l < limbs.size(); ++l) {
        const Limb& limb = limbs[l];
        const Hem& hem = hems[l];
        if (!arms && pair_of(limb.segments[0]) == SegmentPair::upper_arms) continue;
        // Clothes have two legs and two sleeves.
        if (!(hem.step * hems[(l + 2) % limbs.size()].step > 0)) continue;
        const bool leg = pair_of(limb.segments[0]) == SegmentPair::thighs, towards_trunk = hem.step < 0;
        const bool on_upper = hem.along < limb.upper();
        if (towards_trunk || on_upper) dress(pair_of(limb.segments[0]));
        if (!towards_trunk || !on_upper) dress(pair_of(limb.segments[1]));
        if (towards_trunk && leg) dress(SegmentPair::hips);
        if (towards_trunk && !leg) {
            dress(SegmentPair::chest);
            dress(SegmentPair::belly);
        }
        if (!towards_trunk && !leg) dress(SegmentPair::hands);
        for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
            const int bone = bone_of(limb, static_cast<int>(v));
            if (bone < 0) continue;
            const double along = limb.along(rest.vertices.row(v).transpose(), bone);
            if (towards_trunk ? along < hem.along + gap : along > hem.along - gap) result.covered[v] = 1;
        }
    }
    return result;
}

}  // namespace ndg
