// SPDX-License-Identifier: Apache-2.0
#include "ndg/placement/trunk_bones.h"

#include "ndg/body_source/bone_parts.h"
#include "ndg/core/error.h"
#include "ndg/placement/interpolation.h"
#include "ndg/placement/skin_section.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {
namespace {

constexpr double process_half_width = 0.012;  ///< m from a vertebra's midline
constexpr double body_share = 0.4;            ///< of a vertebra's vertices, the foremost ones: its body
constexpr double section_step = 0.01;

constexpr std::array<const char*, 12> ordinals = {"first",   "second", "third", "fourth", "fifth",    "sixth",
                                                  "seventh", "eighth", "ninth", "tenth",  "eleventh", "twelfth"};

std::vector<std::string> vertebrae_from_c7()
{
    std::vector<std::string> names = {"seventh cervical vertebra"};
    for (const char* ordinal : ordinals) names.push_back(std::string(ordinal) + " thoracic vertebra");
    for (int k = 0; k < 5; ++k) names.push_back(std::string(ordinals[k]) + " lumbar vertebra");
    return names;
}

/// Those of `names` that there are.
std::vector<const AnatomyMesh*> parts_of(const PartFinder& finder, const std::vector<std::string>& names)
{
    std::vector<const AnatomyMesh*> found;
    for (const std::string& name : names)
        if (const AnatomyMesh* part = finder.find(name)) found.push_back(part);
    return found;
}

/// Calls `visit` with the height and the section of all `parts` together, every section_step between their ends.
template <typename Visit>
void sections(const std::vector<const AnatomyMesh*>& parts, double half_width, const Visit& visit)
{
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (const AnatomyMesh* part : parts) {
        low = std::min(low, part->vertices.col(1).minCoeff());
        high = std::max(high, part->vertices.col(1).maxCoeff());
    }
    for (double y = low + 0.5 * section_step; y < high; y += section_step) {
        Section section;
        for (const AnatomyMesh* part : parts)
            widen_section(part->vertices, part->triangles, {}, y, half_width, section);
        if (!section.empty()) visit(y, section);
    }
}

}  // namespace

Eigen::Vector3d spinous_tip(const Eigen::Ref<const Points>& vertebra)
{
    std::vector<double> depths(vertebra.rows());
    for (Eigen::Index v = 0; v < vertebra.rows(); ++v) depths[v] = vertebra(v, 2);
    const auto limit = depths.begin() + static_cast<std::ptrdiff_t>((1.0 - body_share) * double(depths.size()));
    std::nth_element(depths.begin(), limit, depths.end());
    Eigen::RowVector3d body = Eigen::RowVector3d::Zero();
    double count = 0.0;
    for (Eigen::Index v = 0; v < vertebra.rows(); ++v) {
        if (vertebra(v, 2) < *limit) continue;
        body += vertebra.row(v);
        count += 1.0;
    }
    body /= count;
    Eigen::Index tip = 0;
    double farthest = -1.0;
    for (Eigen::Index v = 0; v < vertebra.rows(); ++v) {
        const Eigen::RowVector3d arm = vertebra.row(v) - body;
        if (arm[2] > 0.0 || std::abs(arm[0]) > process_half_width || arm.norm() <= farthest) continue;
        farthest = arm.norm();
        tip = v;
    }
    return vertebra.row(tip).transpose();
}

double TrunkBones::spinous_z(double height) const
{
    std::vector<double> heights, depths;
    for (Eigen::Index l = spinous_tips.rows(); l-- > 0;) {
        heights.push_back(spinous_tips(l, 1));
        depths.push_back(spinous_tips(l, 2));
    }
    return interpolate(heights, depths, height);
}

double TrunkBones::mid_sternum_height() const
{
    return 0.5 * (sternum_heights.front() + sternum_heights.back());
}

double TrunkBones::cage_depth() const
{
    const double y = mid_sternum_height();
    return interpolate(sternum_heights, sternum_fronts, y) - spinous_z(y);
}

double TrunkBones::cage_breadth() const
{
    return 2.0 * *std::max_element(rib_half_breadths.begin(), rib_half_breadths.end());
}

TrunkBones trunk_bones(const std::vector<AnatomyMesh>& parts)
{
    TrunkBones bones;
    const PartFinder finder(parts);
    const std::vector<std::string> vertebrae = vertebrae_from_c7();
    bones.spinous_tips.setZero(static_cast<Eigen::Index>(vertebrae.size()), 3);
    for (std::size_t level = 0; level < vertebrae.size(); ++level)
        bones.spinous_tips.row(level) = spinous_tip(finder.part(vertebrae[level]).vertices).transpose();
    std::vector<std::string> rib_names;
    for (const char* ordinal : ordinals)
        for (const char* side : {"left ", "right "}) rib_names.push_back(side + std::string(ordinal) + " rib");
    const auto sternum = parts_of(finder, {"manubrium", "body of sternum", "sternum"}),
               ribs = parts_of(finder, rib_names), hips = parts_of(finder, {"left hip bone", "right hip bone"});
    require(!sternum.empty() && !ribs.empty() && !hips.empty(),
            "the skeleton has no sternum, no ribs or no hip bones, which its trunk is placed by");
    for (Eigen::Index level = 1; level < bones.spinous_tips.rows(); ++level)
        require(bones.spinous_tips(level, 1) < bones.spinous_tips(level - 1, 1),
                "the tip of the bone '{}' does not lie below that of the one above", vertebrae[level]);
    sections(sternum, midline_half_width, [&](double y, const Section& section) {
        bones.sternum_heights.push_back(y);
        bones.sternum_fronts.push_back(section.front);
    });
    sections(ribs, 1.0, [&](double y, const Section& section) {
        bones.rib_heights.push_back(y);
        bones.rib_half_breadths.push_back(section.half_width);
    });
    bones.pelvis_top = hips.front()->vertices.col(1).maxCoeff();
    sections(hips, 1.0, [&](double y, const Section& section) {
        if (section.half_width <= bones.crest_half_breadth) return;
        bones.crest_height = y;
        bones.crest_half_breadth = section.half_width;
    });
    require(bones.sternum_heights.size() > 2, "the sternum does not reach the midline");
    return bones;
}

}  // namespace ndg
