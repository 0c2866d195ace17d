// SPDX-License-Identifier: Apache-2.0
#include "ndg/placement/trunk_map.h"

#include "ndg/body/skeleton.h"
#include "ndg/body_source/bone_cover.h"
#include "ndg/core/error.h"
#include "ndg/placement/interpolation.h"
#include "ndg/placement/skin_section.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <string>

namespace ndg {
namespace {

constexpr double section_step = 0.02;
constexpr int smoothing_steps = 6;

/// Depth and breadth of the rib cage and breadth of the pelvis over stature: chest depth and breadth and biiliac
/// breadth by caliper of 247 men and 260 women (Heinz et al. 2003, Journal of Statistics Education 11; 208, 300 and 281
/// mm at 1777 mm, 177, 261 and 276 mm at 1649 mm) less the skin under the caliper; and how they grow with the body mass
/// index, from 23, per kg/m^2, which is chosen: in CT of 649 in-patients the cage is 214 by 317 mm.
struct BonyTrunk {
    double cage_depth, cage_breadth, pelvis_breadth;
};
BonyTrunk bony_trunk(const TrunkTarget& target)
{
    const BonyTrunk female = {0.1025, 0.151, 0.164}, male = {0.1115, 0.161, 0.155};
    const double growth = 1.0 + 0.001 * (target.bmi - 23.0);
    const auto at = [&](double of_women, double of_men) {
        return target.stature * ((1.0 - target.sex) * of_women + target.sex * of_men);
    };
    return {growth * at(female.cage_depth, male.cage_depth), growth * at(female.cage_breadth, male.cage_breadth),
            at(female.pelvis_breadth, male.pelvis_breadth)};
}

/// How far the skin may draw the cage away from that, and its thoracic index (depth over breadth), about 0.69.
constexpr double cage_spread = 0.02, least_index = 0.65, greatest_index = 0.70;
/// Top of the iliac crest above the hip joint, over stature: heights of the iliac crest, 0.611 F and 0.604 M, and of
/// the trochanterion, 0.519 and 0.513 (ANSUR II, Gordon et al. 2014), less what skin lies on the crest.
constexpr double crest_rise = 0.083;
/// Of the source's curves of the spine against the skin's, and how far they may draw a vertebra from its depth, m.
constexpr double curve_weight = 60.0, most_deviation = 0.006;
/// Skin outside of breastbone and ribs, and outside of the crests, m.
constexpr double least_cover = 0.006, least_crest_cover = 0.010;
/// The skin's say in the breadth of the pelvis.
constexpr double skin_share = 0.4;

void smooth(std::vector<double>& values, int steps)
{
    for (int step = 0; step < steps; ++step) {
        const std::vector<double> old = values;
        for (std::size_t i = 1; i + 1 < values.size(); ++i) values[i] = 0.25 * (old[i - 1] + 2 * old[i] + old[i + 1]);
    }
}

/// Offsets near the wanted ones with second differences near zero, so that the spine keeps the source's curves:
/// least squares, then within most_deviation of the wanted.
std::vector<double> like_the_source(const std::vector<double>& wanted)
{
    const auto count = static_cast<Eigen::Index>(wanted.size());
    const Eigen::Map<const Eigen::VectorXd> offsets(wanted.data(), count);
    Eigen::MatrixXd bend = Eigen::MatrixXd::Zero(count - 2, count);
    for (Eigen::Index i = 0; i + 2 < count; ++i) bend.row(i).segment<3>(i) << 1.0, -2.0, 1.0;
    const Eigen::MatrixXd system = Eigen::MatrixXd::Identity(count, count) + curve_weight * bend.transpose() * bend;
    const Eigen::VectorXd smooth_offsets = system.llt().solve(offsets);
    std::vector<double> result(wanted.size());
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] =
            wanted[i] + std::clamp(smooth_offsets[Eigen::Index(i)] - wanted[i], -most_deviation, most_deviation);
    return result;
}

double mean_of_sides(const Eigen::Ref<const Points>& joints, const std::string& joint, int coordinate)
{
    const Skeleton& skeleton = standard_skeleton();
    return 0.5 *
           (joints(skeleton.joint("left_" + joint), coordinate) + joints(skeleton.joint("right_" + joint), coordinate));
}

Section trunk_section(const TrunkTarget& target, double y, double half_width)
{
    Section section;
    widen_section(target.vertices, target.triangles, target.on_trunk, y, half_width, section);
    require(!section.empty(), "the skin has no trunk at a height of {:.3f} m", y);
    return section;
}

}  // namespace

std::vector<char> on_trunk(const Eigen::Ref<const RowMatrix>& weights)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<char> result(weights.rows(), 0);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(weights.rows());
    for (int j = 0; j < skeleton.num_joints(); ++j)
        for (const char* prefix : {"pelvis", "spine", "neck", "left_clav", "right_clav"})
            if (skeleton.joint_names[j].rfind(prefix, 0) == 0) sum += weights.col(j);
    for (Eigen::Index v = 0; v < sum.size(); ++v) result[v] = sum[v] > 0.5;
    return result;
}

TrunkMap::TrunkMap(const TrunkBones& bones, const Eigen::Ref<const Points>& source_joints, const TrunkTarget& target)
{
    fit_heights(bones, source_joints, target);
    fit_breadths(bones, target);
    fit_depths(bones, source_joints, target);
}

void TrunkMap::fit_heights(const TrunkBones& bones, const Eigen::Ref<const Points>& source_joints,
                           const TrunkTarget& target)
{
    const int head = standard_skeleton().joint("head");
    const double target_hip = mean_of_sides(target.joints, "thigh", 1);
    height_knots_ = {mean_of_sides(source_joints, "thigh", 1), bones.pelvis_top,
                     mean_of_sides(source_joints, "clavicle", 1), source_joints(head, 1)};
    height_values_ = {target_hip, target_hip + crest_rise * target.stature, mean_of_sides(target.joints, "clavicle", 1),
                      target.joints(head, 1)};
    for (int k = 0; k < 3; ++k)
        require(height_knots_[k + 1] > height_knots_[k] && height_values_[k + 1] > height_values_[k],
                "hips, crests, clavicles and head do not lie above each other");
    stature_scale_ = (height_values_.back() - height_values_.front()) / (height_knots_.back() - height_knots_.front());
}

double TrunkMap::height(double source_height) const
{
    return interpolate_monotone(height_knots_, height_values_, source_height);
}

void TrunkMap::fit_breadths(const TrunkBones& bones, const TrunkTarget& target)
{
    const BonyTrunk usual = bony_trunk(target);
    // Breastbone to back as the skin has it in the mean over the breastbone, against the source's.
    double by_skin = 0.0, most_depth = 1e3;
    for (std::size_t i = 0; i < bones.sternum_heights.size(); ++i) {
        const double y = bones.sternum_heights[i];
        const Section section = trunk_section(target, height(y), midline_half_width);
        const double room = section.front - section.back - sternum_depth(target.bmi) - spinous_depth(4.0, target.bmi);
        const double depth = bones.sternum_fronts[i] - bones.spinous_z(y);
        by_skin += room / depth;
        most_depth = std::min(most_depth, (room + sternum_depth(target.bmi) - least_cover) / depth);
    }
    const double usual_scale = usual.cage_depth / bones.cage_depth();
    const double depth_scale =
        std::min(most_depth, std::clamp(by_skin / static_cast<double>(bones.sternum_heights.size()),
                                        (1.0 - cage_spread) * usual_scale, (1.0 + cage_spread) * usual_scale));
    const double depth = depth_scale * bones.cage_depth();
    // Breadth where the cage is broadest, below the armpits.
    double skin_breadth = 0.0, count = 0.0, most_breadth = 1e3;
    const double armpit = 0.5 * (bones.sternum_heights.front() + bones.sternum_heights.back());
    for (std::size_t i = 0; i < bones.rib_heights.size(); ++i) {
        if (bones.rib_heights[i] > armpit || 2.0 * bones.rib_half_breadths[i] < 0.95 * bones.cage_breadth()) continue;
        const Section section = trunk_section(target, height(bones.rib_heights[i]), 1.0);
        skin_breadth += 2.0 * (section.half_width - rib_side_depth(target.bmi));
        most_breadth = std::min(most_breadth, 2.0 * (section.half_width - least_cover));
        count += 1.0;
    }
    double breadth = count > 0.0 ? skin_breadth / count : usual.cage_breadth;
    breadth = std::clamp(breadth, (1.0 - cage_spread) * usual.cage_breadth, (1.0 + cage_spread) * usual.cage_breadth);
    breadth = std::min(most_breadth, std::clamp(breadth, depth / greatest_index, depth / least_index));
    const double cage_scale = breadth / bones.cage_breadth();

    const Section crest = trunk_section(target, height(bones.crest_height), 1.0);
    const double by_crest = crest.half_width - rib_side_depth(target.bmi);
    double half_pelvis = (1.0 - skin_share) * 0.5 * usual.pelvis_breadth +
                         skin_share * std::clamp(by_crest, 0.42 * usual.pelvis_breadth, 0.58 * usual.pelvis_breadth);
    half_pelvis = std::min(half_pelvis, crest.half_width - least_crest_cover);
    const double pelvis_scale = half_pelvis / bones.crest_half_breadth;

    const double hip = height_knots_.front(), collar = height_knots_[2], head = height_knots_[3];
    const double cage_end =
        bones.rib_heights.front() + 0.25 * (bones.sternum_heights.front() - bones.rib_heights.front());
    for (double y = hip - 0.12; y <= head + section_step; y += section_step) {
        section_heights_.push_back(y);
        const double of_cage = smoothstep(bones.crest_height, cage_end, y);
        const double of_neck = smoothstep(collar, head, y);
        double x = pelvis_scale + of_cage * (cage_scale - pelvis_scale);
        double z = stature_scale_ +
                   smoothstep(bones.crest_height, bones.sternum_heights.front(), y) * (depth_scale - stature_scale_);
        x += of_neck * (stature_scale_ - x);
        z += of_neck * (stature_scale_ - z);
        scale_x_.push_back(x);
        scale_z_.push_back(z);
    }
    smooth(scale_x_, smoothing_steps);
    smooth(scale_z_, smoothing_steps);
}

void TrunkMap::fit_depths(const TrunkBones& bones, const Eigen::Ref<const Points>& source_joints,
                          const TrunkTarget& target)
{
    std::vector<double> heights, offsets;
    for (Eigen::Index level = bones.spinous_tips.rows(); level-- > 0;) {
        const double y = bones.spinous_tips(level, 1);
        const double back = trunk_section(target, height(y), midline_half_width).back;
        heights.push_back(y);
        offsets.push_back(back + spinous_depth(static_cast<double>(level), target.bmi) -
                          interpolate(section_heights_, scale_z_, y) * bones.spinous_tips(level, 2));
    }
    offsets = like_the_source(offsets);
    const int head = standard_skeleton().joint("head");
    heights.push_back(std::max(source_joints(head, 1), heights.back() + section_step));
    offsets.push_back(target.joints(head, 2) -
                      interpolate(section_heights_, scale_z_, source_joints(head, 1)) * source_joints(head, 2));
    offset_heights_ = heights;
    offset_z_ = offsets;
}

Eigen::Vector3d TrunkMap::operator()(const Eigen::Vector3d& source) const
{
    const double y = source[1];
    return {interpolate(section_heights_, scale_x_, y) * source[0], height(y),
            interpolate(section_heights_, scale_z_, y) * source[2] + interpolate(offset_heights_, offset_z_, y)};
}

}  // namespace ndg
