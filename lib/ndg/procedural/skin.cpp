// SPDX-License-Identifier: Apache-2.0
// Trunk, neck and limbs of the procedural skin. Tables are in centimetres on the drawing board of 1.70 m.
#include "ndg/procedural/skin.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace ndg {

namespace {

constexpr double centimetre = 0.01;

/// One size of a section: the lean value of women and men, and what a unit of fat and of muscle add.
struct Size {
    double female, male, fat = 0.0, muscle = 0.0;

    double value(const BodyLayout& layout) const
    {
        const double girth = layout.girth();
        // Leanness takes more evenly than fat is added: where much can come, there is not as much to go.
        const double fat_amount = girth > 0.0 ? fat * girth : 0.6 * std::sqrt(fat) * girth;
        const double cm = layout.by_sex(female, male) + fat_amount +
                          muscle * (layout.muscle() + std::min(0.0, 0.4 * girth));  // the lean have less muscle too
        return std::max(cm, 0.55 * layout.by_sex(female, male)) * centimetre * layout.unit();
    }
};

/// A section of the trunk at a height of the drawing board.
struct TrunkRow {
    double y, centre_z;
    Size breadth, front, back;
};

// Heights: crotch 0.80, hip (buttock) 0.88, iliac crest 1.01, waist 1.07, lower ribs 1.15, chest 1.25, armpit 1.30.
const std::initializer_list<TrunkRow> trunk_rows = {
    {0.835, -0.010, {12.2, 11.2, 0.9, 0.2}, {6.2, 6.4, 0.6, 0.1}, {7.0, 7.0, 0.7, 0.3}},
    {0.885, -0.012, {16.2, 15.2, 1.35, 0.3}, {8.2, 8.6, 1.0, 0.1}, {9.6, 9.0, 0.9, 0.4}},
    {0.945, -0.012, {16.0, 15.4, 1.40, 0.2}, {9.4, 9.6, 1.7, 0.1}, {9.4, 9.0, 1.0, 0.3}},
    {1.005, -0.012, {14.0, 14.2, 1.60, 0.2}, {9.8, 10.0, 2.3, 0.1}, {7.4, 7.8, 1.0, 0.2}},
    {1.065, -0.012, {12.2, 13.3, 1.75, 0.3}, {9.6, 10.2, 2.5, 0.1}, {6.8, 7.6, 1.1, 0.3}},
    {1.130, -0.014, {12.3, 13.8, 1.40, 0.3}, {9.8, 10.8, 2.1, 0.2}, {7.6, 8.4, 1.0, 0.4}},
    {1.200, -0.018, {13.1, 15.0, 1.00, 0.5}, {10.4, 11.9, 1.4, 0.3}, {8.8, 9.6, 0.9, 0.5}},
    {1.265, -0.024, {13.8, 16.0, 0.85, 0.8}, {10.4, 12.4, 0.9, 0.5}, {9.6, 10.4, 0.9, 0.6}},
    {1.325, -0.030, {13.7, 15.8, 0.60, 0.8}, {9.0, 10.8, 0.6, 0.5}, {9.2, 10.0, 0.8, 0.6}},
    {1.375, -0.034, {11.6, 13.4, 0.60, 0.6}, {6.8, 8.0, 0.4, 0.3}, {7.8, 8.6, 0.7, 0.5}},
    {1.415, -0.038, {7.0, 8.2, 0.50, 0.5}, {5.2, 6.0, 0.4, 0.3}, {5.8, 6.6, 0.6, 0.5}},
};

/// A section of a limb at a share of its length.
struct LimbRow {
    double s, centre_u, centre_w;  ///< centimetres beside the axis
    Size outer, inner, front, back;
};

// Hip joint to ankle; the knee is at 0.497. Thigh, calf and ankle circumferences 59, 37 and 22 cm.
const std::initializer_list<LimbRow> leg_rows = {
    {-0.02, 0.2, 0.0, {8.0, 7.6, 1.1, 0.4}, {7.6, 7.4, 0.5, 0.3}, {8.4, 8.6, 0.8, 0.6}, {8.6, 8.4, 0.8, 0.5}},
    {0.10, 0.1, 0.1, {8.7, 8.1, 1.15, 0.5}, {8.3, 7.9, 0.9, 0.5}, {8.7, 8.8, 0.9, 0.7}, {8.7, 8.5, 1.0, 0.6}},
    {0.22, 0.0, 0.5, {7.9, 7.6, 1.0, 0.6}, {7.7, 7.5, 1.0, 0.5}, {8.2, 8.4, 0.9, 0.8}, {8.2, 8.0, 1.0, 0.6}},
    {0.34, -0.1, 1.1, {6.7, 6.7, 0.8, 0.5}, {6.6, 6.6, 0.8, 0.5}, {6.9, 7.2, 0.7, 0.6}, {7.3, 7.1, 0.8, 0.5}},
    {0.43, -0.3, 1.4, {5.5, 5.6, 0.6, 0.2}, {5.8, 5.9, 0.7, 0.4}, {5.6, 5.9, 0.5, 0.3}, {6.6, 6.5, 0.7, 0.3}},
    {0.497, -0.4, 1.5, {5.0, 5.3, 0.4, 0.1}, {5.2, 5.4, 0.6, 0.1}, {5.0, 5.4, 0.4, 0.1}, {6.0, 6.0, 0.6, 0.2}},
    {0.56, -0.3, 1.1, {4.9, 5.1, 0.4, 0.2}, {4.8, 5.0, 0.5, 0.2}, {4.6, 4.9, 0.35, 0.1}, {6.2, 6.3, 0.6, 0.4}},
    {0.66, 0.0, 0.2, {5.0, 5.2, 0.5, 0.4}, {5.1, 5.2, 0.5, 0.4}, {4.3, 4.6, 0.35, 0.3}, {6.9, 7.1, 0.6, 0.7}},
    {0.76, 0.1, -0.2, {4.3, 4.4, 0.45, 0.3}, {4.2, 4.3, 0.4, 0.3}, {3.9, 4.2, 0.3, 0.2}, {5.7, 5.9, 0.5, 0.5}},
    {0.87, 0.0, -0.3, {3.2, 3.3, 0.3, 0.1}, {3.2, 3.3, 0.3, 0.1}, {3.5, 3.7, 0.25, 0.0}, {4.2, 4.5, 0.3, 0.1}},
    {0.95, 0.0, -0.2, {3.1, 3.3, 0.2, 0.0}, {3.1, 3.3, 0.2, 0.0}, {3.6, 3.8, 0.2, 0.0}, {4.2, 4.5, 0.2, 0.0}},
    {1.00, 0.0, 0.0, {3.5, 3.7, 0.15, 0.0}, {3.5, 3.7, 0.15, 0.0}, {3.9, 4.1, 0.15, 0.0}, {4.2, 4.5, 0.15, 0.0}},
};

// Shoulder to wrist; the elbow is at 0.521. u: away from the trunk, w: forwards. Upper arm, forearm and wrist
// circumferences 29, 26 and 16.5 cm.
const std::initializer_list<LimbRow> arm_rows = {
    {-0.03, 0.6, 0.2, {3.9, 4.8, 0.6, 0.5}, {4.0, 4.6, 0.2, 0.2}, {4.8, 5.6, 0.6, 0.6}, {4.9, 5.6, 0.6, 0.5}},
    {0.08, 0.4, 0.0, {4.6, 5.5, 0.75, 0.7}, {4.8, 5.4, 0.35, 0.3}, {4.8, 5.6, 0.75, 0.6}, {5.0, 5.7, 0.8, 0.5}},
    {0.18, 0.2, -0.2, {4.2, 4.9, 0.8, 0.6}, {4.3, 4.8, 0.5, 0.4}, {4.3, 4.9, 0.75, 0.5}, {4.7, 5.2, 0.9, 0.5}},
    {0.30, 0.0, -0.5, {3.7, 4.3, 0.7, 0.4}, {3.9, 4.4, 0.65, 0.4}, {4.4, 5.0, 0.7, 0.8}, {4.3, 4.9, 0.8, 0.7}},
    {0.41, 0.0, -0.8, {3.5, 4.0, 0.5, 0.3}, {3.5, 3.9, 0.6, 0.2}, {4.0, 4.5, 0.5, 0.5}, {3.8, 4.3, 0.5, 0.3}},
    {0.51, 0.0, -1.0, {3.6, 4.2, 0.4, 0.2}, {3.5, 3.9, 0.45, 0.1}, {3.8, 4.3, 0.4, 0.2}, {3.5, 3.9, 0.35, 0.0}},
    {0.61, 0.1, -0.6, {3.8, 4.5, 0.4, 0.5}, {3.4, 3.9, 0.45, 0.3}, {4.1, 4.7, 0.4, 0.5}, {3.6, 4.1, 0.4, 0.3}},
    {0.74, 0.0, -0.2, {3.2, 3.7, 0.3, 0.4}, {3.0, 3.4, 0.35, 0.2}, {3.5, 4.0, 0.3, 0.3}, {3.3, 3.7, 0.35, 0.2}},
    {0.87, 0.0, 0.2, {2.3, 2.6, 0.2, 0.1}, {2.3, 2.6, 0.2, 0.1}, {2.8, 3.2, 0.2, 0.1}, {2.8, 3.1, 0.2, 0.1}},
    {0.96, 0.0, 0.4, {1.9, 2.15, 0.15, 0.0}, {1.9, 2.15, 0.15, 0.0}, {2.7, 3.0, 0.15, 0.0}, {2.7, 3.0, 0.15, 0.0}},
    {1.00, 0.0, 0.4, {1.8, 2.0, 0.1, 0.0}, {1.8, 2.0, 0.1, 0.0}, {2.7, 3.0, 0.1, 0.0}, {2.7, 3.0, 0.1, 0.0}},
};

/// The tube with the sections of a limb.
Tube limb_tube(Tube tube, const BodyLayout& layout, std::initializer_list<LimbRow> rows)
{
    for (const LimbRow& row : rows)
        tube.sections.push_back({row.s, row.centre_u * centimetre * layout.unit(),
                                 row.centre_w * centimetre * layout.unit(), row.outer.value(layout),
                                 row.inner.value(layout), row.front.value(layout), row.back.value(layout)});
    tube.prepare();
    return tube;
}

double size(const BodyLayout& layout, const Size& value)
{
    return value.value(layout);
}

}  // namespace

void add_trunk(Field& field, const BodyLayout& layout)
{
    field.begin_group(0.02, Field::Side::middle, skin_trunk);
    const double lowest = layout.height(trunk_rows.begin()->y), highest = layout.height((trunk_rows.end() - 1)->y);
    Tube trunk{{0.0, lowest, 0.0},       Eigen::Vector3d::UnitY(), highest - lowest,      Eigen::Vector3d::UnitX(),
               Eigen::Vector3d::UnitZ(), 0.030 * layout.unit(),    0.020 * layout.unit(), 2.35};
    const ProceduralParameters& p = layout.parameters();
    for (const TrunkRow& row : trunk_rows) {
        const double up = std::clamp((row.y - 1.00) / 0.20, 0.0, 1.0);
        const double wide = p.hip_breadth + up * (p.shoulder_breadth - p.hip_breadth);
        const double breadth = row.breadth.value(layout) * wide;
        trunk.sections.push_back({(layout.height(row.y) - trunk.origin.y()) / trunk.length, 0.0,
                                  row.centre_z * layout.unit(), breadth, breadth, row.front.value(layout),
                                  row.back.value(layout)});
    }
    field.add(trunk, 0.02);

    // Chest: pectoral muscle and breast, shoulder blades, buttocks; each half blends with its mirror image.
    field.begin_group(layout.by_sex(0.045, 0.060) * layout.unit(), Field::Side::blended, skin_trunk);
    const double u = layout.unit();
    const double breast = size(layout, {1.0, 0.0, 0.0, 0.0}) / (0.01 * u);  // 0 to 1
    const double chest = p.shoulder_breadth;
    Ellipsoid pectoral;
    pectoral.centre = layout.place(layout.by_sex(0.070, 0.080) * chest, layout.by_sex(1.278, 1.284), 0.0);
    pectoral.centre.z() = size(layout, {6.0, 5.5, 0.55, 0.5});
    pectoral.radii = {size(layout, {7.0, 8.2, 0.5, 0.6}), size(layout, {5.6, 7.6, 0.4, 0.3}),
                      size(layout, {3.2, 3.6, 0.2, 0.5})};
    field.add(pectoral, 0.035 * u);
    Ellipsoid mamma;
    const double fullness = breast * (1.0 + 0.10 * std::clamp(layout.girth(), -0.8, 3.0));
    mamma.centre = layout.place(0.074 * chest, layout.by_sex(1.238, 1.262), 0.0);
    mamma.centre.z() = size(layout, {8.2, 5.2, 0.75, 0.3});
    mamma.radii = u * Eigen::Vector3d(0.030 + 0.026 * fullness, 0.028 + 0.027 * fullness, 0.020 + 0.026 * fullness);
    field.add(mamma, 0.03 * u);
    field.begin_group(0.05 * u, Field::Side::mirrored, skin_trunk);
    Ellipsoid blade;
    blade.centre = layout.place(layout.by_sex(0.080, 0.092) * chest, 1.300, 0.0);
    blade.centre.z() = -size(layout, {8.6, 9.6, 0.6, 0.5});
    blade.radii = {size(layout, {5.0, 5.8, 0.3, 0.5}), 0.078 * u, size(layout, {3.0, 3.3, 0.2, 0.4})};
    field.add(blade, 0.04 * u);
    // Latissimus: from the armpit down to the waist.
    field.add(Capsule{layout.place(layout.by_sex(0.112, 0.130) * chest, 1.295, -0.052),
                      layout.place(layout.by_sex(0.080, 0.092) * chest, 1.130, -0.060),
                      size(layout, {3.4, 4.2, 0.2, 0.8}), size(layout, {2.6, 3.0, 0.4, 0.3})},
              0.05 * u);
    field.begin_group(0.035 * u, Field::Side::blended, skin_trunk);
    Ellipsoid buttock;
    buttock.centre = layout.place(layout.by_sex(0.076, 0.072) * p.hip_breadth, layout.by_sex(0.888, 0.892), 0.0);
    buttock.centre.z() = -size(layout, {7.0, 6.4, 0.45, 0.4});
    buttock.radii = {size(layout, {7.2, 6.8, 0.7, 0.4}), size(layout, {7.8, 7.6, 0.7, 0.4}),
                     size(layout, {6.6, 6.3, 0.75, 0.6})};
    field.add(buttock, (0.014 + 0.009 * std::clamp(layout.girth(), 0.0, 4.0)) * u);
}

void add_neck(Field& field, const BodyLayout& layout)
{
    const double u = layout.unit();
    field.begin_group(0.030 * u, Field::Side::middle, skin_neck);
    const double radius = size(layout, {5.2, 5.9, 0.45, 0.45});
    const double upper = size(layout, {5.2, 5.9, 0.18, 0.35});  // below the ears
    field.add(Capsule{layout.place(0.0, 1.395, -0.040), layout.place(0.0, 1.545, -0.012), 1.06 * radius, upper},
              0.02 * u);
    field.begin_group(0.045 * u, Field::Side::mirrored, skin_trunk);
    const double chest = layout.parameters().shoulder_breadth;
    // Upper trapezius from the neck to the acromion, and the collar bone.
    field.add(
        Capsule{layout.place(0.030, 1.462, -0.046), layout.place(layout.by_sex(0.135, 0.150) * chest, 1.392, -0.034),
                size(layout, {2.8, 3.3, 0.4, 0.8}), size(layout, {2.6, 3.0, 0.4, 0.5})},
        0.03 * u);
    field.add(
        Capsule{layout.place(0.022, 1.392, 0.026), layout.place(layout.by_sex(0.140, 0.156) * chest, 1.392, -0.010),
                size(layout, {1.5, 1.7, 0.2, 0.2}), size(layout, {1.7, 2.0, 0.3, 0.3})},
        0.02 * u);
    // Sternocleidomastoid.
    field.add(Capsule{layout.place(0.018, 1.405, 0.020), layout.place(0.052, 1.545, -0.014), 0.009 * u, 0.014 * u},
              0.02 * u);
}

void add_leg(Field& field, const BodyLayout& layout)
{
    const double u = layout.unit();
    field.begin_group(0.055 * u, Field::Side::mirrored, skin_leg);
    const Eigen::Vector3d hip = layout.joint("left_thigh"), ankle = layout.joint("left_foot");
    const Tube leg = limb_tube(
        {hip, layout.leg_axis(), (ankle - hip).norm(), layout.leg_out(), layout.leg_front(), 0.10 * u, 0.035 * u},
        layout, leg_rows);
    field.add(leg, 0.02 * u);
    field.clip_middle(0.006 * u, 0.02 * u);  // thick thighs flatten against each other
    // Kneecap and the hollow's sides, calf heads, ankle bones.
    Ellipsoid kneecap;
    kneecap.centre = layout.joint("left_shin") + u * (0.039 * leg.w + 0.012 * Eigen::Vector3d::UnitY());
    kneecap.radii = u * Eigen::Vector3d(0.022, 0.027, 0.016);
    field.add(kneecap, 0.018 * u);
    for (const double side : {1.0, -1.0}) {
        Ellipsoid malleolus;
        malleolus.centre = ankle + u * (side * (0.031 + layout.by_sex(0.0, 0.002)) * leg.u +
                                        (side > 0 ? 0.0 : 0.008) * Eigen::Vector3d::UnitY());
        malleolus.radii = u * Eigen::Vector3d(0.009, 0.014, 0.012);
        field.add(malleolus, 0.012 * u);
        Ellipsoid calf;  // gastrocnemius, the inner head lower and larger
        calf.centre = leg.centre(side > 0 ? 0.640 : 0.665) + u * side * 0.022 * leg.u -
                      size(layout, {3.0, 3.2, 0.3, 0.5}) * leg.w;
        calf.axes.col(0) = leg.u;
        calf.axes.col(1) = leg.axis;
        calf.axes.col(2) = leg.w;
        calf.radii = {size(layout, {2.5, 2.6, 0.2, 0.3}), 0.075 * u, size(layout, {3.4, 3.5, 0.2, 0.4})};
        field.add(calf, 0.03 * u);
    }
}

void add_arm(Field& field, const BodyLayout& layout)
{
    const double u = layout.unit();
    field.begin_group(0.05 * u, Field::Side::mirrored, skin_arm);
    const Eigen::Vector3d shoulder = layout.joint("left_upper_arm");
    const Tube arm =
        limb_tube({shoulder, layout.arm_axis(), (layout.joint("left_hand") - shoulder).norm(), layout.arm_up(),
                   Eigen::Vector3d::UnitZ(), size(layout, {3.6, 4.4, 0.5, 0.4}), 0.02 * u},
                  layout, arm_rows);
    field.add(arm, 0.02 * u);
    // Point of the elbow.
    Ellipsoid olecranon;
    olecranon.centre = layout.joint("left_forearm") - 0.027 * u * Eigen::Vector3d::UnitZ() - 0.004 * u * arm.axis;
    olecranon.radii = u * Eigen::Vector3d(0.013, 0.013, 0.012);
    field.add(olecranon, 0.018 * u);
}

Field skin_field(const BodyLayout& layout)
{
    Field field;
    add_trunk(field, layout);
    add_neck(field, layout);
    add_leg(field, layout);
    add_arm(field, layout);
    add_head(field, layout);
    add_foot(field, layout);
    add_hand(field, layout);
    field.set_floor(0.0, 0.006);
    return field;
}

}  // namespace ndg
