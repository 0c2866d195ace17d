// SPDX-License-Identifier: Apache-2.0
// Skull, spine, thorax and pelvis; positions are metres on the drawing board of 1.70 m. Sizes of vertebrae after
// Panjabi et al. 1992 (Spine 17:299) and 1991 (16:888), of the pelvis after Reynolds, Snow and Young 1982.
#include "ndg/procedural/bones.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

constexpr double pi = 3.14159265358979323846;

using Vec = Eigen::Vector3d;

struct SpinePlan {
    const char* name;
    int fma_id;
    double y, z;  ///< centre of the body
    double half_width, half_height, half_depth;
    double transverse, spinous, slope;  ///< reach of the processes, and how far the spinous one goes down
    const char* joint;
};

constexpr std::array<SpinePlan, 24> vertebrae = {{
    {"Atlas", 12519, 1.5290, -0.0135, 0.012, 0.0050, 0.0070, 0.034, 0.022, 0.000, "head"},
    {"Axis", 12520, 1.5120, -0.0160, 0.010, 0.0070, 0.0075, 0.026, 0.034, 0.006, "neck_2"},
    {"Third cervical vertebra", 12521, 1.4945, -0.0190, 0.010, 0.0068, 0.0078, 0.025, 0.031, 0.006, "neck_2"},
    {"Fourth cervical vertebra", 12522, 1.4780, -0.0225, 0.010, 0.0066, 0.0080, 0.025, 0.031, 0.006, "neck_2"},
    {"Fifth cervical vertebra", 12523, 1.4615, -0.0265, 0.011, 0.0066, 0.0082, 0.026, 0.033, 0.007, "neck_1"},
    {"Sixth cervical vertebra", 12524, 1.4455, -0.0315, 0.012, 0.0066, 0.0084, 0.027, 0.036, 0.008, "neck_1"},
    {"Seventh cervical vertebra", 12525, 1.4290, -0.0370, 0.013, 0.0070, 0.0088, 0.031, 0.043, 0.010, "neck_1"},
    {"First thoracic vertebra", 9165, 1.4110, -0.0425, 0.014, 0.0075, 0.0090, 0.034, 0.045, 0.014, "spine_5"},
    {"Second thoracic vertebra", 9187, 1.3920, -0.0480, 0.014, 0.0080, 0.0095, 0.032, 0.044, 0.018, "spine_5"},
    {"Third thoracic vertebra", 9209, 1.3725, -0.0530, 0.013, 0.0082, 0.0100, 0.031, 0.044, 0.021, "spine_5"},
    {"Fourth thoracic vertebra", 9248, 1.3525, -0.0570, 0.013, 0.0084, 0.0105, 0.030, 0.044, 0.024, "spine_5"},
    {"Fifth thoracic vertebra", 9922, 1.3320, -0.0600, 0.013, 0.0086, 0.0110, 0.030, 0.044, 0.026, "spine_4"},
    {"Sixth thoracic vertebra", 9945, 1.3110, -0.0615, 0.0135, 0.0088, 0.0115, 0.030, 0.044, 0.027, "spine_4"},
    {"Seventh thoracic vertebra", 9968, 1.2895, -0.0615, 0.0140, 0.0090, 0.0120, 0.030, 0.044, 0.027, "spine_4"},
    {"Eighth thoracic vertebra", 9991, 1.2670, -0.0600, 0.0145, 0.0094, 0.0125, 0.030, 0.044, 0.026, "spine_4"},
    {"Ninth thoracic vertebra", 10014, 1.2440, -0.0570, 0.0150, 0.0098, 0.0130, 0.029, 0.044, 0.024, "spine_3"},
    {"Tenth thoracic vertebra", 10037, 1.2200, -0.0530, 0.0155, 0.0102, 0.0135, 0.028, 0.044, 0.021, "spine_3"},
    {"Eleventh thoracic vertebra", 10059, 1.1950, -0.0480, 0.0160, 0.0106, 0.0140, 0.026, 0.044, 0.016, "spine_3"},
    {"Twelfth thoracic vertebra", 10081, 1.1685, -0.0425, 0.0175, 0.0112, 0.0145, 0.026, 0.045, 0.012, "spine_2"},
    {"First lumbar vertebra", 13072, 1.1390, -0.0370, 0.0205, 0.0122, 0.0155, 0.036, 0.048, 0.006, "spine_2"},
    {"Second lumbar vertebra", 13073, 1.1075, -0.0325, 0.0210, 0.0126, 0.0160, 0.038, 0.049, 0.005, "spine_2"},
    {"Third lumbar vertebra", 13074, 1.0750, -0.0295, 0.0220, 0.0128, 0.0165, 0.041, 0.050, 0.005, "spine_1"},
    {"Fourth lumbar vertebra", 13075, 1.0420, -0.0290, 0.0230, 0.0130, 0.0170, 0.040, 0.049, 0.005, "spine_1"},
    {"Fifth lumbar vertebra", 13076, 1.0085, -0.0320, 0.0235, 0.0130, 0.0170, 0.040, 0.045, 0.006, "pelvis"},
}};

/// Half-axes of the rib cage and how far each rib drops from the spine to its front end.
struct RibPlan {
    const char* name;
    int fma_left, fma_right;
    double half_width, half_depth, drop, last_angle;  ///< angle in degrees from the back
};
constexpr std::array<RibPlan, 12> rib_plans = {{{"First rib", 7987, 7857, 0.052, 0.038, 0.030, 158},
                                                {"Second rib", 8012, 7882, 0.073, 0.051, 0.040, 161},
                                                {"Third rib", 8039, 7909, 0.091, 0.062, 0.052, 163},
                                                {"Fourth rib", 8148, 7957, 0.104, 0.071, 0.062, 165},
                                                {"Fifth rib", 8093, 8066, 0.112, 0.078, 0.072, 166},
                                                {"Sixth rib", 8202, 8175, 0.117, 0.083, 0.082, 167},
                                                {"Seventh rib", 8256, 8229, 0.120, 0.086, 0.088, 167},
                                                {"Eighth rib", 8310, 8283, 0.121, 0.087, 0.094, 152},
                                                {"Ninth rib", 8391, 8364, 0.119, 0.086, 0.098, 138},
                                                {"Tenth rib", 8472, 8445, 0.115, 0.083, 0.098, 124},
                                                {"Eleventh rib", 8532, 0, 0.108, 0.078, 0.075, 92},
                                                {"Twelfth rib", 8534, 0, 0.092, 0.068, 0.045, 62}}};

BoneSketch vertebra(const BodyLayout& layout, std::size_t idx)
{
    const SpinePlan& plan = vertebrae[idx];
    const double u = layout.unit() * layout.by_sex(0.95, 1.02);
    const Vec centre = layout.place(0.0, plan.y, plan.z);
    // Axis along the spine, from the neighbours.
    const SpinePlan &upper = vertebrae[idx == 0 ? 0 : idx - 1], &lower = vertebrae[std::min<std::size_t>(idx + 1, 23)];
    const Vec up = (layout.place(0.0, upper.y, upper.z) - layout.place(0.0, lower.y, lower.z)).normalized();
    const Vec front = Vec::UnitX().cross(up).normalized();
    const auto at = [&](double x, double y, double z) -> Vec {
        return centre + u * (x * Vec::UnitX() + y * up + z * front);
    };
    BoneSketch sketch{plan.name, plan.joint, plan.fma_id, plan.fma_id, 0.0055 * u, false, {}};
    sketch.field.begin_group(0.003, Field::Side::blended);
    const double d = plan.half_depth, w = plan.half_width, h = plan.half_height;
    Tube body{at(0.0, -0.85 * h, 0.0), up, 1.7 * h * u, Vec::UnitX(), front, 0.3 * h * u, 0.3 * h * u, 2.3};
    for (const double s : {0.0, 0.5, 1.0}) {
        const double waist = s == 0.5 ? 0.90 : 1.0;
        body.sections.push_back({s, 0.0, 0.0, waist * w * u, waist * w * u, waist * d * u, 0.9 * d * u});
    }
    if (idx == 0) {  // the atlas is a ring
        sketch.field.add(Capsule{at(0.0, 0.0, 0.008), at(0.018, 0.0, -0.002), 0.0045 * u, 0.0075 * u}, 0.004 * u);
        sketch.field.add(Capsule{at(0.018, 0.0, -0.002), at(0.0, 0.0, -plan.spinous), 0.0060 * u, 0.0045 * u},
                         0.004 * u);
    } else {
        sketch.field.add(body, 0.004 * u);
        sketch.field.add(
            Capsule{at(0.62 * w, 0.3 * h, -0.8 * d), at(0.95 * w, 0.1 * h, -d - 0.010), 0.0048 * u, 0.0055 * u},
            0.004 * u);
        sketch.field.add(Capsule{at(0.95 * w, 0.0, -d - 0.010), at(0.0, -0.2 * h, -d - 0.019), 0.0052 * u, 0.0050 * u},
                         0.004 * u);
        sketch.field.add(Capsule{at(0.0, -0.2 * h, -d - 0.018), at(0.0, -0.2 * h - plan.slope, -plan.spinous),
                                 0.0050 * u, 0.0045 * u},
                         0.004 * u);
    }
    const double back = idx < 7 ? -0.3 * d : -d - 0.012;  // cervical transverse processes stand beside the body
    sketch.field.add(Capsule{at(0.8 * w, 0.0, back), at(plan.transverse, 0.1 * h, back - (idx < 7 ? 0.0 : 0.006)),
                             0.0050 * u, 0.0042 * u},
                     0.004 * u);
    return sketch;
}

BoneSketch rib(const BodyLayout& layout, std::size_t idx)
{
    const RibPlan& plan = rib_plans[idx];
    const SpinePlan& level = vertebrae[idx + 7];
    const double u = layout.unit();
    const double wide = layout.by_sex(0.94, 1.03) * (0.5 + 0.5 * layout.parameters().shoulder_breadth);
    const double deep = layout.by_sex(0.93, 1.03);
    BoneSketch sketch{plan.name, level.joint, plan.fma_left, plan.fma_right, 0.0062 * u, true, {}};
    sketch.field.begin_group(0.002, Field::Side::middle);
    constexpr int pieces = 14;
    Vec last = layout.place(0.014, level.y, level.z - 0.012);
    for (int i = 0; i <= pieces; ++i) {
        const double begin = 14.0, angle = (begin + (plan.last_angle - begin) * i / pieces) * pi / 180.0;
        // The cage's own ellipse leans forward: its centre lies before the spine.
        const double along = angle / pi;
        const double down =
            plan.drop * (along < 0.72 ? std::pow(along / 0.72, 1.2) : 1.0 - 0.30 * (along - 0.72) / 0.28);
        const double round = std::pow(std::abs(std::sin(angle)), 0.85);
        const double centre_z = level.z + 0.55 * plan.half_depth - 0.012;
        Vec x = layout.place(wide * plan.half_width * round, level.y - down,
                             centre_z - deep * plan.half_depth * 1.16 * std::cos(angle));
        if (i == 0) x = 0.4 * x + 0.6 * last;
        const double radius = (i > 10 ? 0.0052 : 0.0056) * u;
        sketch.field.add(Capsule{last, x, radius, radius}, 0.001 * u);
        last = x;
    }
    return sketch;
}

BoneSketch hip_bone(const BodyLayout& layout)
{
    const double u = layout.unit();
    const Vec hip = layout.joint("left_thigh");
    const double wide = layout.parameters().hip_breadth * layout.by_sex(1.03, 0.99);
    const auto at = [&](double x, double y, double z) -> Vec { return layout.place(wide * x, y, z); };
    BoneSketch sketch{"Hip bone", "pelvis", 16587, 16586, 0.0075 * u, true, {}};
    sketch.field.begin_group(0.004, Field::Side::middle);
    const Vec socket = hip + u * Vec(0.002, 0.002, -0.003);
    const Vec spine = at(0.106, 0.985, 0.046), crest_front = at(0.124, 1.012, 0.020), crest = at(0.126, 1.024, -0.018),
              crest_back = at(0.090, 1.018, -0.060), back = at(0.046, 0.985, -0.078),
              sciatic = at(0.050, 0.945, -0.062);
    const double thin = 0.0048 * u;
    const Vec centre = at(0.084, 0.975, -0.028);
    const std::array<Vec, 6> rim = {spine, crest_front, crest, crest_back, back, sciatic};
    for (std::size_t i = 0; i + 1 < rim.size(); ++i) {
        sketch.field.add(Plate{rim[i], rim[i + 1], centre, thin}, 0.004 * u);
        sketch.field.add(Capsule{rim[i], rim[i + 1], 0.0075 * u, 0.0075 * u}, 0.005 * u);
    }
    sketch.field.add(Plate{spine, centre, socket, thin}, 0.004 * u);
    sketch.field.add(Plate{sciatic, centre, socket, 1.6 * thin}, 0.004 * u);
    sketch.field.add(Capsule{at(0.100, 0.955, 0.040), socket, 0.0075 * u, 0.014 * u}, 0.006 * u);
    sketch.field.add(Ellipsoid{socket, u * Vec(0.030, 0.031, 0.031)}, 0.008 * u);
    // Pubis and ischium around the obturator foramen.
    const Vec pubis = at(0.012, 0.880, 0.048), sitting = at(0.056, 0.838, -0.032);
    sketch.field.add(Capsule{socket + u * Vec(-0.012, 0.000, 0.018), pubis, 0.011 * u, 0.0090 * u}, 0.006 * u);
    sketch.field.add(Capsule{pubis, at(0.014, 0.866, 0.044), 0.0085 * u, 0.0080 * u}, 0.004 * u);
    sketch.field.add(Capsule{at(0.014, 0.866, 0.042), sitting, 0.0070 * u, 0.0085 * u}, 0.005 * u);
    sketch.field.add(Capsule{socket + u * Vec(-0.004, -0.014, -0.016), sitting, 0.013 * u, 0.0145 * u}, 0.006 * u);
    sketch.field.carve(Ellipsoid{hip + u * Vec(0.006, -0.003, 0.002), u * Vec(0.0262, 0.0262, 0.0262)}, 0.003 * u);
    return sketch;
}

BoneSketch sacrum(const BodyLayout& layout)
{
    const double u = layout.unit() * layout.by_sex(0.98, 1.0);
    BoneSketch sketch{"Sacrum", "pelvis", 16202, 16202, 0.0075 * u, false, {}};
    sketch.field.begin_group(0.004, Field::Side::blended);
    const Vec top = layout.place(0.0, 0.978, -0.050), tip = layout.place(0.0, 0.878, -0.078);
    const Vec down = (tip - top).normalized();
    Vec front = Vec::UnitX().cross(down).normalized();
    if (front.z() < 0.0) front = -front;
    Tube body{top, down, (tip - top).norm(), Vec::UnitX(), front, 0.006 * u, 0.006 * u, 2.3};
    const std::array<std::array<double, 4>, 5> rows = {{{0.0, 0.046, 0.016, 0.000},
                                                        {0.25, 0.042, 0.014, -0.008},
                                                        {0.50, 0.032, 0.011, -0.013},
                                                        {0.75, 0.020, 0.008, -0.010},
                                                        {1.0, 0.008, 0.005, 0.000}}};
    for (const auto& r : rows) body.sections.push_back({r[0], 0.0, u * r[3], u * r[1], u * r[1], u * r[2], u * r[2]});
    sketch.field.add(body, 0.004 * u);
    for (int i = 0; i < 4; ++i) {  // spinous tubercles
        const double s = 0.08 + 0.19 * i;
        sketch.field.add(
            Ellipsoid{body.origin + s * body.length * body.axis - u * (0.020 + 0.004 * std::sin(pi * s)) * body.w,
                      u * Vec(0.005, 0.009, 0.008)},
            0.006 * u);
    }
    return sketch;
}

BoneSketch sternum(const BodyLayout& layout)
{
    const double u = layout.unit();
    BoneSketch sketch{"Sternum", "spine_4", 7485, 7485, 0.0062 * u, false, {}};
    sketch.field.begin_group(0.003, Field::Side::blended);
    const Vec top = layout.place(0.0, 1.388, layout.by_sex(0.014, 0.020)),
              angle = layout.place(0.0, 1.345, layout.by_sex(0.034, 0.042)),
              end = layout.place(0.0, 1.235, layout.by_sex(0.064, 0.076)),
              tip = layout.place(0.0, 1.205, layout.by_sex(0.066, 0.078));
    const double thick = 0.0058 * u;
    const Vec x = u * Vec::UnitX();
    sketch.field.add(Plate{top + 0.019 * x, top - 0.004 * x, angle + 0.010 * x, thick}, 0.004 * u);
    sketch.field.add(Plate{top - 0.004 * x, angle - 0.004 * x, angle + 0.010 * x, thick}, 0.004 * u);
    sketch.field.add(Plate{angle + 0.010 * x, angle - 0.004 * x, end + 0.014 * x, thick}, 0.004 * u);
    sketch.field.add(Plate{angle - 0.004 * x, end - 0.004 * x, end + 0.014 * x, thick}, 0.004 * u);
    sketch.field.add(Capsule{end, tip, 0.0068 * u, 0.0042 * u}, 0.005 * u);
    return sketch;
}

}  // namespace

std::vector<BoneSketch> head_bone_sketches(const BodyLayout& layout)
{
    const double u = layout.unit() * layout.by_sex(0.985, 1.01);
    const Vec crown = layout.place(0.0, 1.70, 0.0);
    const auto at = [&](double x, double y, double z) -> Vec { return crown + u * Vec(x, y - 1.70, z); };
    const auto radii = [&](double x, double y, double z) -> Vec { return u * Vec(x, y, z); };

    BoneSketch skull{"Skull without mandible", "head", 0, 0, 0.0062 * u, false, {}};
    Field& s = skull.field;
    s.begin_group(0.008 * u, Field::Side::blended);
    s.add(Ellipsoid{at(0.0, 1.618, -0.010), radii(0.0672, 0.0765, 0.0875)}, 0.01 * u);
    s.add(Ellipsoid{at(0.0, 1.575, -0.030), radii(0.0480, 0.0380, 0.0560)}, 0.03 * u);
    // Upper jaw and face.
    s.add(Capsule{at(0.0, 1.560, 0.050), at(0.0, 1.530, 0.056), 0.026 * u, 0.020 * u}, 0.02 * u);
    s.add(Capsule{at(0.010, 1.598, 0.068), at(0.048, 1.600, 0.052), 0.0090 * u, 0.0075 * u}, 0.008 * u);  // brow
    s.add(Capsule{at(0.050, 1.602, 0.050), at(0.052, 1.572, 0.046), 0.0065 * u, 0.0080 * u}, 0.006 * u);  // outer orbit
    s.add(Capsule{at(0.050, 1.566, 0.050), at(0.022, 1.560, 0.060), 0.0090 * u, 0.0110 * u}, 0.008 * u);  // cheek
    s.add(Capsule{at(0.053, 1.566, 0.046), at(0.0655, 1.570, 0.012), 0.0055 * u, 0.0045 * u}, 0.004 * u);  // arch
    s.add(Capsule{at(0.0655, 1.570, 0.012), at(0.0610, 1.573, -0.004), 0.0045 * u, 0.0070 * u}, 0.006 * u);
    s.add(Capsule{at(0.0, 1.594, 0.074), at(0.0, 1.576, 0.086), 0.0075 * u, 0.0050 * u}, 0.006 * u);      // nasal bones
    s.add(Capsule{at(0.0, 1.5350, 0.072), at(0.022, 1.5350, 0.060), 0.0085 * u, 0.0075 * u}, 0.006 * u);  // upper teeth
    s.add(Capsule{at(0.022, 1.5350, 0.060), at(0.028, 1.5370, 0.036), 0.0075 * u, 0.0070 * u}, 0.006 * u);
    s.add(Capsule{at(0.052, 1.562, -0.014), at(0.047, 1.540, -0.008), 0.0095 * u, 0.0060 * u}, 0.008 * u);  // mastoid
    s.carve(Ellipsoid{at(0.0300, 1.5830, 0.0700), radii(0.0175, 0.0155, 0.0290)}, 0.006 * u);
    s.carve(Ellipsoid{at(0.0050, 1.5620, 0.0820), radii(0.0080, 0.0140, 0.0180)}, 0.004 * u);
    s.carve(Ellipsoid{at(0.0600, 1.5900, 0.0280), radii(0.0140, 0.0240, 0.0220)}, 0.012 * u);  // temple

    BoneSketch mandible{"Mandible", "jaw", 52748, 52748, 0.0058 * u, false, {}};
    Field& m = mandible.field;
    m.begin_group(0.006 * u, Field::Side::blended);
    m.add(Capsule{at(0.0, 1.4955, 0.0660), at(0.022, 1.4985, 0.0570), 0.0095 * u, 0.0085 * u}, 0.008 * u);
    m.add(Capsule{at(0.022, 1.4985, 0.0570), at(0.0445, 1.5170, 0.0130), 0.0085 * u, 0.0080 * u}, 0.008 * u);
    m.add(Capsule{at(0.0445, 1.5170, 0.0130), at(0.0500, 1.5560, 0.0060), 0.0085 * u, 0.0060 * u}, 0.008 * u);
    m.add(Plate{at(0.0420, 1.5160, 0.0200), at(0.0480, 1.5500, 0.0080), at(0.0460, 1.5510, 0.0240), 0.0042 * u},
          0.006 * u);
    m.add(Capsule{at(0.0, 1.5120, 0.0690), at(0.020, 1.5140, 0.0580), 0.0075 * u, 0.0070 * u}, 0.008 * u);  // teeth
    m.add(Capsule{at(0.020, 1.5140, 0.0580), at(0.0330, 1.5200, 0.0330), 0.0070 * u, 0.0065 * u}, 0.008 * u);
    return {std::move(skull), std::move(mandible)};
}

std::vector<BoneSketch> trunk_bone_sketches(const BodyLayout& layout)
{
    std::vector<BoneSketch> sketches;
    for (std::size_t i = 0; i < vertebrae.size(); ++i) sketches.push_back(vertebra(layout, i));
    for (std::size_t i = 0; i < rib_plans.size(); ++i) sketches.push_back(rib(layout, i));
    sketches.push_back(sternum(layout));
    sketches.push_back(sacrum(layout));
    sketches.push_back(hip_bone(layout));
    return sketches;
}

}  // namespace ndg
