// SPDX-License-Identifier: Apache-2.0
// Head, hands and feet of the procedural skin; positions are metres on the drawing board of 1.70 m.
#include "ndg/geometry/rotation.h"
#include "ndg/procedural/skin.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

/// Sections from rows of place, centre (u, w) and half-axes (outer, inner, front, back) at unit size, with fat on all
/// half-axes.
template <std::size_t N>
void add_sections(Tube& tube, const std::array<std::array<double, 7>, N>& rows, double unit, double fat,
                  double fat_back)
{
    for (const auto& r : rows)
        tube.sections.push_back({r[0], unit * r[1], unit * r[2], unit * r[3] + fat, unit * r[4] + fat,
                                 unit * r[5] + fat, unit * r[6] + fat_back});
}

}  // namespace

void add_head(Field& field, const BodyLayout& layout)
{
    const double u = layout.head_scale(), male = layout.parameters().sex;
    // The face gains little after the first kilograms, and must not grow over the ears.
    const double fat = layout.girth() > 0.0 ? 1.5 * (1.0 - std::exp(-layout.girth() / 1.5)) : 0.6 * layout.girth();
    const Eigen::Vector3d crown = layout.place(0.0, 1.70, 0.0);
    // Relative to the crown, so that the head keeps its proportions.
    const auto at = [&](double x, double y, double z) -> Eigen::Vector3d {
        return crown + u * Eigen::Vector3d(x, y - 1.70, z);
    };
    const auto radii = [&](double x, double y, double z) -> Eigen::Vector3d { return u * Eigen::Vector3d(x, y, z); };

    field.begin_group(0.028 * u, Field::Side::blended, skin_head);
    field.add(Ellipsoid{at(0.0, 1.612, -0.008), radii(0.0735, 0.0895, 0.0945)}, 0.02 * u);
    // The face: sections from the chin up to the brow.
    Tube face{at(0.0, 1.496, 0.030),
              Eigen::Vector3d::UnitY(),
              0.110 * u,
              Eigen::Vector3d::UnitX(),
              Eigen::Vector3d::UnitZ(),
              0.014 * u,
              0.028 * u,
              2.2};
    const double jaw = 0.0015 * male + 0.0020 * fat;
    const std::array<std::array<double, 4>, 6> face_rows = {{{0.00, 0.0290, 0.047, 0.030},
                                                             {0.16, 0.0425, 0.051, 0.035},
                                                             {0.34, 0.0510, 0.0525, 0.040},
                                                             {0.56, 0.0580, 0.0520, 0.040},
                                                             {0.78, 0.0630, 0.0505, 0.040},
                                                             {1.00, 0.0640, 0.0545, 0.040}}};
    for (const auto& row : face_rows) {
        const double width = u * (row[1] + jaw * (1.1 - 0.7 * row[0]));
        face.sections.push_back({row[0], 0.0, 0.0, width, width, u * row[2], u * row[3]});
    }
    field.add(face, 0.022 * u);
    // Jaw from chin to the angle below the ear, cheek bones, double chin.
    field.add(Capsule{at(0.016, 1.4985, 0.062), at(0.0450 + 0.003 * male, 1.5240, 0.012),
                      u * (0.0120 + 0.0014 * male + 0.4 * jaw), u * (0.0145 + 0.0016 * male + 0.8 * jaw)},
              0.030 * u);
    field.add(Ellipsoid{at(0.0, 1.4945, 0.0690), radii(0.0165 + 0.003 * male, 0.0130, 0.0135)}, 0.020 * u);
    field.add(Ellipsoid{at(0.0430, 1.5580, 0.0600), radii(0.0190, 0.0160, 0.0170)}, 0.030 * u);
    field.add(Ellipsoid{at(0.0330, 1.5250, 0.0530), radii(0.0200, 0.0260, 0.0200)}, 0.030 * u);
    field.add(Capsule{at(0.0, 1.500, 0.030), at(0.0, 1.515, 0.0), u * (0.020 + 0.007 * fat), u * (0.025 + 0.006 * fat)},
              0.03 * u);
    // Eyes: sockets, then balls behind lids.
    field.carve(Ellipsoid{at(0.0320, 1.5875, 0.0950), radii(0.0200, 0.0130, 0.0190)}, 0.012 * u);
    // Brow: a ridge, stronger in men.
    field.add(Capsule{at(0.010, 1.6010, 0.0815), at(0.040, 1.6040, 0.0700), u * (0.0070 + 0.0016 * male),
                      u * (0.0055 + 0.0012 * male)},
              0.016 * u);
    // Nose: bridge, tip, wings; then nostrils.
    field.add(Capsule{at(0.0, 1.5960, 0.0830), at(0.0, 1.5610, 0.0985 + 0.002 * male), u * 0.0062, u * 0.0090},
              0.012 * u);
    field.add(Ellipsoid{at(0.0, 1.5575, 0.0995 + 0.003 * male), radii(0.0095, 0.0085, 0.0100)}, 0.008 * u);
    field.add(Ellipsoid{at(0.0112, 1.5535, 0.0900), radii(0.0068 + 0.0008 * male, 0.0070, 0.0098)}, 0.006 * u);
    field.carve(Ellipsoid{at(0.0065, 1.5465, 0.0960), radii(0.0034, 0.0034, 0.0052)}, 0.004 * u);
    // Mouth: the two lips, meeting in a groove.
    field.add(Ellipsoid{at(0.0, 1.5270, 0.0770), radii(0.0290, 0.0180, 0.0105)}, 0.018 * u);
    field.add(Capsule{at(0.0040, 1.5296, 0.0885), at(0.0125, 1.5288, 0.0868), u * 0.0046, u * 0.0040}, 0.005 * u);
    field.add(Capsule{at(0.0125, 1.5288, 0.0868), at(0.0245, 1.5248, 0.0808), u * 0.0040, u * 0.0026}, 0.005 * u);
    field.add(Capsule{at(0.0000, 1.5192, 0.0868), at(0.0120, 1.5202, 0.0852), u * 0.0056, u * 0.0048}, 0.0020 * u);
    field.add(Capsule{at(0.0120, 1.5202, 0.0852), at(0.0235, 1.5232, 0.0805), u * 0.0048, u * 0.0028}, 0.0020 * u);

    // Eyeballs, then the lids around them.
    field.begin_group(0.0020 * u, Field::Side::mirrored, skin_head);
    field.add(Ellipsoid{at(0.0315, 1.5875, 0.0685), radii(0.0125, 0.0125, 0.0128)}, 0.004 * u);
    field.begin_group(0.0060 * u, Field::Side::mirrored, skin_head);
    const std::array<Eigen::Vector3d, 4> upper = {at(0.0185, 1.5860, 0.0745), at(0.0270, 1.5930, 0.0795),
                                                  at(0.0370, 1.5930, 0.0775), at(0.0445, 1.5865, 0.0660)};
    const std::array<Eigen::Vector3d, 4> lower = {at(0.0185, 1.5850, 0.0735), at(0.0270, 1.5815, 0.0770),
                                                  at(0.0370, 1.5815, 0.0755), at(0.0445, 1.5855, 0.0660)};
    for (std::size_t i = 0; i + 1 < upper.size(); ++i) {
        field.add(Capsule{upper[i], upper[i + 1], 0.0036 * u, 0.0036 * u}, 0.002 * u);
        field.add(Capsule{lower[i], lower[i + 1], 0.0032 * u, 0.0032 * u}, 0.002 * u);
    }

    // Ears: shell with a hollow, lobe.
    field.begin_group(0.007 * u, Field::Side::mirrored, skin_head);
    Ellipsoid shell{at(0.0785, 1.5760, -0.0100), radii(0.0078, 0.0300, 0.0180)};
    shell.axes = about_y(-0.45) * about_x(-0.18);
    field.add(shell, 0.006 * u);
    field.add(Ellipsoid{at(0.0745, 1.5500, -0.0030), radii(0.0052, 0.0090, 0.0080)}, 0.006 * u);
    Ellipsoid hollow{at(0.0855, 1.5740, -0.0030), radii(0.0070, 0.0170, 0.0085)};
    hollow.axes = shell.axes;
    field.carve(hollow, 0.006 * u);
}

void add_foot(Field& field, const BodyLayout& layout)
{
    const double u = layout.foot_scale();
    const double fat = 0.0012 * layout.girth();
    const Eigen::Vector3d ankle = layout.joint("left_foot"), up = Eigen::Vector3d::UnitY();
    const Eigen::Vector3d front = layout.foot_front(), out = layout.foot_out();
    const Eigen::Vector3d below(ankle.x(), 0.0, ankle.z());
    const auto at = [&](double f, double o, double h) -> Eigen::Vector3d {
        return below + u * (f * front + o * out + h * up);
    };
    field.begin_group(0.028 * u, Field::Side::mirrored, skin_foot);
    // From heel to the ball: sections across the foot.
    Tube foot{at(-0.040, 0.0, 0.0), front, 0.178 * u, out, up, 0.022 * u, 0.016 * u, 2.3};
    // s, centre out, centre height, outer, inner, top, bottom
    const std::array<std::array<double, 7>, 6> rows = {{{0.00, 0.000, 0.034, 0.0270, 0.0270, 0.034, 0.033},
                                                        {0.20, 0.000, 0.034, 0.0300, 0.0300, 0.044, 0.033},
                                                        {0.42, 0.002, 0.030, 0.0320, 0.0320, 0.046, 0.029},
                                                        {0.65, 0.003, 0.026, 0.0360, 0.0345, 0.033, 0.025},
                                                        {0.86, 0.004, 0.021, 0.0410, 0.0400, 0.021, 0.020},
                                                        {1.00, 0.004, 0.017, 0.0400, 0.0410, 0.0130, 0.016}}};
    add_sections(foot, rows, u, fat, 0.0);  // the sole bears the body: no fat is added below
    field.add(foot, 0.02 * u);
    field.add(Ellipsoid{at(-0.042, 0.0, 0.030), u * Eigen::Vector3d(0.027, 0.029, 0.026)}, 0.02 * u);
    // Toes: start, lateral place, length, radius.
    const std::array<std::array<double, 5>, 5> toes = {{{0.132, -0.0290, 0.052, 0.0130, 0.0116},
                                                        {0.136, -0.0018, 0.047, 0.0098, 0.0086},
                                                        {0.132, 0.0125, 0.042, 0.0092, 0.0081},
                                                        {0.125, 0.0270, 0.037, 0.0087, 0.0077},
                                                        {0.115, 0.0395, 0.032, 0.0082, 0.0073}}};
    field.begin_group(0.008 * u, Field::Side::mirrored, skin_foot);
    for (const auto& t : toes)
        field.add(Capsule{at(t[0], t[1], t[3] + 0.001), at(t[0] + t[2], t[1] * 0.98, t[4]), u * t[3], u * t[4]},
                  0.0035 * u);
}

void add_hand(Field& field, const BodyLayout& layout)
{
    const double u = layout.hand_scale();
    const double fat = 0.0004 * layout.girth() + 0.0003 * layout.muscle();  // of the palm; fingers keep their gaps
    const Eigen::Vector3d wrist = layout.joint("left_hand"), along = layout.arm_axis();
    const Eigen::Vector3d side = layout.thumb_side(), palm = layout.palm_side();
    const auto at = [&](double a, double s, double p) -> Eigen::Vector3d {
        return wrist + u * (a * along + s * side + p * palm);
    };
    field.begin_group(0.022 * u, Field::Side::mirrored, skin_palm);
    Tube hand{wrist, along, 0.094 * u, side, palm, 0.020 * u, 0.013 * u, 2.4};
    // s, centre to the thumb, centre to the palm, thumb side, little finger side, palm, back
    const std::array<std::array<double, 7>, 5> rows = {{{0.00, 0.003, 0.001, 0.0255, 0.0255, 0.0165, 0.0165},
                                                        {0.25, 0.001, 0.002, 0.0290, 0.0300, 0.0165, 0.0155},
                                                        {0.55, 0.000, 0.001, 0.0335, 0.0350, 0.0145, 0.0140},
                                                        {0.85, 0.000, 0.000, 0.0370, 0.0380, 0.0120, 0.0120},
                                                        {1.00, -0.001, 0.000, 0.0370, 0.0370, 0.0100, 0.0100}}};
    add_sections(hand, rows, u, fat, fat);
    field.add(hand, 0.02 * u);
    // Balls of thumb and little finger.
    Ellipsoid thenar{at(0.040, 0.020, 0.013), u * Eigen::Vector3d(0.028, 0.016, 0.013)};
    thenar.axes.col(0) = (0.85 * along + 0.45 * side + 0.27 * palm).normalized();
    thenar.axes.col(1) = thenar.axes.col(0).cross(palm).normalized();
    thenar.axes.col(2) = thenar.axes.col(0).cross(thenar.axes.col(1));
    field.add(thenar, 0.016 * u);
    Ellipsoid hypothenar{at(0.042, -0.024, 0.010), u * Eigen::Vector3d(0.028, 0.012, 0.010)};
    hypothenar.axes.col(0) = along;
    hypothenar.axes.col(1) = side;
    hypothenar.axes.col(2) = along.cross(side);
    field.add(hypothenar, 0.016 * u);
    for (int f = 0; f < 5; ++f) {
        field.begin_group((f == 0 ? 0.014 : 0.008) * u, Field::Side::mirrored, skin_finger_0 + f);
        const Points p = finger_points(layout, f);
        const FingerPlan& plan = finger_plan(f);
        for (int k = 0; k < 3; ++k)
            field.add(Capsule{p.row(k).transpose(), p.row(k + 1).transpose(), u * plan.radii[k], u * plan.radii[k + 1]},
                      0.004 * u);
    }
}

}  // namespace ndg
