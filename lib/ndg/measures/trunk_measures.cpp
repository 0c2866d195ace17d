// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/bone_cover.h"
#include "ndg/core/error.h"
#include "ndg/measures/measured_parts.h"
#include "ndg/placement/skeleton_placer.h"
#include "ndg/placement/trunk_bones.h"

#include <algorithm>
#include <limits>

namespace ndg {
namespace {

using Vec = Eigen::Vector3d;

constexpr double mean_bmi = 27.2;
const char* const ansur = "ANSUR II, Gordon 2014";

struct Pelvis {
    Vec left_asis, right_asis, left_psis, right_psis;
};

/// Anterior and posterior superior iliac spine: foremost and rearmost point of the hip bone's upper half, in which the
/// pubic bone does not lie.
Pelvis pelvis_of(const MeasuredBones& body)
{
    const Points left = between_shares(body.bone("left hip bone"), Vec::UnitY(), 0.5, 1.0),
                 right = between_shares(body.bone("right hip bone"), Vec::UnitY(), 0.5, 1.0);
    return {farthest(left, Vec::UnitZ()), farthest(right, Vec::UnitZ()), farthest(left, -Vec::UnitZ()),
            farthest(right, -Vec::UnitZ())};
}

/// Hip joint by Harrington et al. 2007 (Journal of Biomechanics 40, 595-602) in the pelvic frame of the four spines:
/// origin midway between the anterior ones, x forward, y up, z to the side of the joint; lengths in mm,
///   x = -0.24 depth - 9.9,  y = -0.16 width - 0.04 leg - 7.1,  z = 0.28 depth + 0.16 width + 7.9
/// with depth from mid-ASIS to mid-PSIS, width between the ASIS and leg from ASIS to medial malleolus.
Vec regression_hip(const Pelvis& p, bool left, const Vec& medial_malleolus)
{
    const Vec origin = 0.5 * (p.left_asis + p.right_asis), back = 0.5 * (p.left_psis + p.right_psis);
    const Vec own = left ? p.left_asis : p.right_asis;
    const Vec side = (own - origin).normalized();
    const Vec forward = (origin - back - side * side.dot(origin - back)).normalized();
    Vec up = side.cross(forward);
    if (up.y() < 0.0) up = -up;
    const double mm = 1e3, depth = mm * (origin - back).norm(), width = mm * (p.left_asis - p.right_asis).norm(),
                 leg = mm * (own - medial_malleolus).norm();
    return origin + ((-0.24 * depth - 9.9) * forward + (-0.16 * width - 0.04 * leg - 7.1) * up +
                     (0.28 * depth + 0.16 * width + 7.9) * side) /
                        mm;
}

/// A gate of three deviations, not below the skin.
void add_cover(MeasureTable& table, const MeasureTable::Row& row, double depth, const Spread& spread)
{
    table.add_gate(row, depth, std::max(0.0, spread.mean - 3.0 * spread.deviation),
                   spread.mean + 3.0 * spread.deviation);
}

void add_pelvis(const MeasuredBones& body, MeasureTable& table)
{
    if (!body.has({"left hip bone", "right hip bone", "left tibia", "right tibia"})) return;
    const Pelvis p = pelvis_of(body);
    // Both grow with fat; the 67 adults stand for the mean body mass index of adults.
    const double flank = rib_side_depth(body.bmi) - rib_side_depth(mean_bmi),
                 back = spinous_depth(level_l5, body.bmi) - spinous_depth(level_l5, mean_bmi);
    // No gate: how it grows with fat is not published.
    const Spread asis{0.0097 + flank, 0.0070};
    table.add_compared(
        {"ASIS, depth", "foremost point of the hip bone's upper half, mean of both sides", MeasureUnit::millimetre,
         "9.7 +- 7.0, CT of 67 adults, Mantovani 2016, and growth with fat (bone_cover.h)"},
        0.5 * (body.depth(p.left_asis) + body.depth(p.right_asis)), asis, asis);
    add_cover(
        table,
        {"PSIS, depth", "rearmost point of the hip bone's upper half, mean of both sides", MeasureUnit::millimetre,
         "19.6 +- 10.9, CT of 67 adults, Mantovani 2016, and growth with fat (bone_cover.h)"},
        0.5 * (body.depth(p.left_psis) + body.depth(p.right_psis)), {0.0196 + back, 0.0109});
    double distance = 0.0;
    for (const bool left : {true, false}) {
        const std::string side = left ? "left" : "right";
        const Vec malleolus = farthest(between_shares(body.bone(side + " tibia"), Vec::UnitY(), 0.0, 0.1),
                                       left ? Vec(-Vec::UnitX()) : Vec(Vec::UnitX()));
        distance += 0.5 * (regression_hip(p, left, malleolus) - body.joint(side + "_thigh")).norm();
    }
    table.add_gate(
        {hip_centre_measure, "hip joint to Harrington 2007 from the bones' ASIS and PSIS, mean of both sides",
         MeasureUnit::millimetre, "12.3 +- 5.9, CT of 67 adults, Mantovani 2016; in the mean 12"},
        distance, 0.0, 0.0123 + 3.0 * 0.0059);
    table.add_compared({"ASIS to ASIS", "between the bony points", MeasureUnit::millimetre,
                        "225 +- 20 F, 227 +- 13 M, CT of 100 adults"},
                       (p.left_asis - p.right_asis).norm(), Spread{0.225, 0.020}, Spread{0.227, 0.013});
    const double breadth = body.bone("left hip bone").col(0).maxCoeff() - body.bone("right hip bone").col(0).minCoeff();
    table.add_gate({"biiliac breadth over stature", "greatest breadth of the hip bones", MeasureUnit::number, ansur},
                   breadth / body.stature_m, Spread{0.168, 0.013}, Spread{0.157, 0.009});
}

void add_thorax(const MeasuredBones& body, MeasureTable& table)
{
    const bool one_sternum = body.has({"sternum"});
    if (!one_sternum && !body.has({"body of sternum", "manubrium"})) return;
    const Points& sternum = body.bone(one_sternum ? "sternum" : "body of sternum");
    // The foremost place of each tenth of its height, but for the ends.
    double depths = 0.0, tenths = 0.0;
    for (int k = 1; k < 9; ++k) {
        const Points tenth = between_shares(sternum, Vec::UnitY(), 0.1 * k, 0.1 * (k + 1));
        if (tenth.rows() == 0) continue;
        depths += body.depth(farthest(tenth, Vec::UnitZ()));
        tenths += 1.0;
    }
    if (tenths > 0.0)
        table.add({"sternum, depth", "mean of its front from top to bottom, to the skin", MeasureUnit::millimetre},
                  depths / tenths);
    double depth = std::numeric_limits<double>::quiet_NaN(), breadth = depth;
    try {
        const TrunkBones trunk = trunk_bones(body.meshes);
        depth = trunk.cage_depth();
        breadth = trunk.cage_breadth();
    } catch (const Error&) {
        // A spine so wrong that its levels are out of order has no depth of the cage, and misses the gate.
    }
    table.add_gate(
        {"rib cage, depth over breadth", "spinous process to breastbone at its middle over breadth of the ribs",
         MeasureUnit::number, "0.675 in CT of 649; 0.68 F, 0.69 M by caliper, Heinz 2003; 0.6 to 0.8"},
        depth / breadth, 0.6, 0.8);
    table.add({"rib cage, breadth over stature", "greatest breadth of the ribs"}, breadth / body.stature_m);
}

void add_shoulders(const MeasuredBones& body, MeasureTable& table)
{
    if (!body.has({"left scapula", "right scapula", "left clavicle", "right clavicle"})) return;
    // Acromion: the scapula's outermost point from above.
    const Vec left = farthest(body.bone("left scapula"), Vec(1.0, 0.6, 0.0)),
              right = farthest(body.bone("right scapula"), Vec(-1.0, 0.6, 0.0));
    table.add_gate(
        {"biacromial breadth over stature", "between the outermost points of the acromia", MeasureUnit::number, ansur},
        (left - right).norm() / body.stature_m, Spread{0.224, 0.010}, Spread{0.237, 0.010});
    table.add({"clavicle, least depth", "mean of both sides", MeasureUnit::millimetre},
              0.5 * (body.cover(body.bone("left clavicle")) + body.cover(body.bone("right clavicle"))));
}

}  // namespace

void add_trunk_measures(const MeasuredBones& body, MeasureTable& table)
{
    if (SkeletonPlacer::has_trunk_bones(body.body_template)) add_thorax(body, table);
    add_shoulders(body, table);
    add_pelvis(body, table);
}

}  // namespace ndg
