// SPDX-License-Identifier: Apache-2.0
// Bones of the left arm and leg, in metres on the drawing board of 1.70 m. Sizes of ends and shafts after Trotter and
// Gleser's and Martin's means as given by White and Folkens 2005 (The Human Bone Manual).
#include "ndg/procedural/bones.h"

#include <array>
#include <cmath>

namespace ndg {

namespace {

using Vec = Eigen::Vector3d;

/// A sketch of a left bone with one group.
BoneSketch start(const char* name, const char* joint, int fma_left, double edge_length, int fma_right = -1)
{
    BoneSketch sketch{name,        joint, fma_left, fma_right >= 0 ? fma_right : fma_left > 0 ? fma_left - 1 : 0,
                      edge_length, true,  {}};
    sketch.field.begin_group(0.004, Field::Side::middle);
    return sketch;
}

/// Capsules through points (x, y, z in metres, radius), blended by k.
void add_chain(Field& field, const std::vector<std::pair<Vec, double>>& points, double k)
{
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
        field.add(Capsule{points[i].first, points[i + 1].first, points[i].second, points[i + 1].second}, k);
}

std::vector<BoneSketch> shoulder_bones(const BodyLayout& layout)
{
    const double u = layout.unit();
    const Vec shoulder = layout.joint("left_upper_arm");
    const double wide = shoulder.x() / (0.176 * u);
    const auto at = [&](double x, double y, double z) -> Vec { return layout.place(wide * x, y, z); };
    std::vector<BoneSketch> bones;
    BoneSketch clavicle = start("Clavicle", "left_clavicle", 13323, 0.0065 * u);
    add_chain(clavicle.field,
              {{layout.joint("left_clavicle") + u * Vec(0.0, 0.0, -0.004), 0.0100 * u},
               {at(0.055, 1.397, 0.024), 0.0062 * u},
               {at(0.095, 1.402, 0.010), 0.0058 * u},
               {at(0.130, 1.405, -0.014), 0.0062 * u},
               {at(0.158, 1.402, -0.030), 0.0075 * u}},
              0.004 * u);
    bones.push_back(std::move(clavicle));

    BoneSketch scapula = start("Scapula", "left_clavicle", 13396, 0.0072 * u);
    Field& s = scapula.field;
    const Vec upper = at(0.066, 1.378, -0.086), lower = at(0.084, 1.240, -0.100),
              socket = shoulder + u * Vec(-0.030, 0.002, -0.008), root = at(0.062, 1.340, -0.098),
              acromion = shoulder + u * Vec(-0.004, 0.036, -0.012);
    const double thin = 0.0042 * u;
    s.add(Plate{upper, root, socket, thin}, 0.004 * u);
    s.add(Plate{root, lower, socket, thin}, 0.004 * u);
    add_chain(s, {{upper, 0.0052 * u}, {root, 0.0052 * u}, {lower, 0.0065 * u}}, 0.004 * u);
    add_chain(s, {{lower, 0.0065 * u}, {socket, 0.0090 * u}}, 0.005 * u);
    s.add(Ellipsoid{socket, u * Vec(0.010, 0.018, 0.013)}, 0.008 * u);
    const Vec ridge = at(0.108, 1.372, -0.094);
    s.add(Plate{root, ridge, socket + u * Vec(-0.020, 0.002, -0.012), thin}, 0.004 * u);
    add_chain(s,
              {{root, 0.0050 * u},
               {ridge, 0.0062 * u},
               {shoulder + u * Vec(-0.012, 0.032, -0.034), 0.0080 * u},
               {acromion, 0.0085 * u}},
              0.004 * u);
    add_chain(s,
              {{socket + u * Vec(-0.010, 0.012, 0.004), 0.0075 * u},
               {shoulder + u * Vec(-0.036, 0.020, 0.022), 0.0065 * u},
               {shoulder + u * Vec(-0.026, 0.010, 0.032), 0.0062 * u}},
              0.005 * u);
    bones.push_back(std::move(scapula));
    return bones;
}

std::vector<BoneSketch> arm_bones(const BodyLayout& layout)
{
    const double u = layout.unit();
    const Vec shoulder = layout.joint("left_upper_arm"), elbow = layout.joint("left_forearm"),
              wrist = layout.joint("left_hand");
    const Vec up = layout.arm_up(), along = layout.arm_axis(), front = Vec::UnitZ();
    const auto from = [&](const Vec& origin, double a, double b, double c) -> Vec {
        return origin + u * (a * along + b * up + c * front);
    };
    std::vector<BoneSketch> bones;
    BoneSketch humerus = start("Humerus", "left_upper_arm", 23131, 0.0082 * u);
    Field& h = humerus.field;
    h.add(Ellipsoid{from(shoulder, -0.002, -0.002, 0.0), u * Vec(0.0225, 0.0225, 0.0225)}, 0.008 * u);
    h.add(Ellipsoid{from(shoulder, 0.008, 0.016, 0.004), u * Vec(0.0150, 0.0150, 0.0150)}, 0.008 * u);
    add_chain(h,
              {{from(shoulder, 0.012, 0.004, 0.002), 0.0165 * u},
               {from(shoulder, 0.070, 0.003, 0.001), 0.0120 * u},
               {0.5 * (shoulder + elbow), 0.0112 * u},
               {from(elbow, -0.060, 0.0, 0.0), 0.0105 * u},
               {from(elbow, -0.012, 0.0, 0.0), 0.0110 * u}},
              0.008 * u);
    h.add(Plate{from(elbow, -0.065, 0.0, 0.0), from(elbow, -0.012, 0.024, 0.0), from(elbow, -0.012, -0.026, 0.0),
                0.0065 * u},
          0.008 * u);
    add_chain(h,
              {{from(elbow, -0.012, 0.025, 0.0), 0.0085 * u},
               {from(elbow, 0.0, 0.014, 0.002), 0.0105 * u},
               {from(elbow, 0.0, -0.012, 0.002), 0.0100 * u},
               {from(elbow, -0.012, -0.028, -0.002), 0.0085 * u}},
              0.005 * u);
    bones.push_back(std::move(humerus));

    BoneSketch radius = start("Radius", "left_forearm_twist", 23465, 0.0068 * u);
    const double length = (wrist - elbow).norm() / u;
    add_chain(radius.field,
              {{from(elbow, 0.016, 0.015, 0.003), 0.0102 * u},
               {from(elbow, 0.030, 0.014, 0.004), 0.0068 * u},
               {from(elbow, 0.42 * length, 0.013, 0.013), 0.0068 * u},
               {from(elbow, 0.78 * length, 0.006, 0.016), 0.0068 * u},
               {from(wrist, -0.022, 0.002, 0.010), 0.0090 * u},
               {from(wrist, -0.010, 0.001, 0.012), 0.0110 * u}},
              0.005 * u);
    radius.field.add(Ellipsoid{from(wrist, -0.010, 0.001, 0.006), u * Vec(0.0105, 0.0105, 0.0130)}, 0.006 * u);
    bones.push_back(std::move(radius));
    BoneSketch ulna = start("Ulna", "left_forearm", 23468, 0.0068 * u);
    add_chain(ulna.field,
              {{from(elbow, -0.014, -0.006, -0.019), 0.0092 * u},
               {from(elbow, 0.004, -0.008, -0.018), 0.0085 * u},
               {from(elbow, 0.024, -0.008, -0.006), 0.0098 * u},
               {from(elbow, 0.06, -0.010, -0.006), 0.0075 * u},
               {from(elbow, 0.5 * length, -0.008, -0.009), 0.0064 * u},
               {from(wrist, -0.030, -0.001, -0.012), 0.0055 * u},
               {from(wrist, -0.014, 0.000, -0.014), 0.0072 * u}},
              0.005 * u);
    ulna.field.add(Ellipsoid{from(elbow, 0.016, -0.007, 0.006), u * Vec(0.0075, 0.0075, 0.0075)}, 0.005 * u);
    bones.push_back(std::move(ulna));
    return bones;
}

std::vector<BoneSketch> leg_bones(const BodyLayout& layout)
{
    const double u = layout.unit();
    const Vec hip = layout.joint("left_thigh"), knee = layout.joint("left_shin"), ankle = layout.joint("left_foot");
    const Vec out = layout.leg_out(), front = layout.leg_front(), down = layout.leg_axis();
    const auto from = [&](const Vec& origin, double d, double o, double f) -> Vec {
        return origin + u * (d * down + o * out + f * front);
    };
    std::vector<BoneSketch> bones;
    BoneSketch femur = start("Femur", "left_thigh", 24475, 0.0092 * u);
    Field& f = femur.field;
    const double length = (knee - hip).norm() / u;
    f.add(Ellipsoid{hip, u * Vec(0.0232, 0.0232, 0.0232)}, 0.006 * u);
    add_chain(f, {{hip, 0.0150 * u}, {from(hip, 0.028, 0.040, -0.004), 0.0160 * u}}, 0.008 * u);
    add_chain(f,
              {{from(hip, 0.006, 0.054, -0.010), 0.0120 * u},
               {from(hip, 0.034, 0.050, -0.006), 0.0175 * u},
               {from(hip, 0.090, 0.040, 0.002), 0.0150 * u},
               {from(hip, 0.45 * length, 0.022, 0.012), 0.0135 * u},
               {from(knee, -0.110, 0.008, 0.004), 0.0140 * u},
               {from(knee, -0.035, 0.000, 0.000), 0.0185 * u}},
              0.012 * u);
    f.add(Ellipsoid{from(hip, 0.070, 0.026, -0.014), u * Vec(0.009, 0.011, 0.009)}, 0.006 * u);  // lesser trochanter
    for (const double side : {1.0, -1.0}) {
        Ellipsoid condyle{from(knee, -0.008, side * 0.0215, -0.006), u * Vec(0.0175, 0.0200, 0.0280)};
        condyle.axes.col(0) = out;
        condyle.axes.col(1) = down;
        condyle.axes.col(2) = out.cross(down);
        f.add(condyle, 0.008 * u);
    }
    f.add(Capsule{from(knee, -0.022, -0.016, 0.012), from(knee, -0.022, 0.016, 0.012), 0.0110 * u, 0.0110 * u},
          0.010 * u);
    bones.push_back(std::move(femur));

    BoneSketch patella = start("Patella", "left_shin", 24487, 0.0060 * u);
    patella.field.add(Ellipsoid{from(knee, -0.012, 0.000, 0.036), u * Vec(0.0190, 0.0200, 0.0085)}, 0.004 * u);
    bones.push_back(std::move(patella));

    BoneSketch tibia = start("Tibia", "left_shin", 24478, 0.0088 * u);
    Field& t = tibia.field;
    for (const double side : {1.0, -1.0}) {
        Ellipsoid plateau{from(knee, 0.026, side * 0.0180, -0.004), u * Vec(0.0185, 0.0125, 0.0225)};
        plateau.axes.col(0) = out;
        plateau.axes.col(1) = down;
        plateau.axes.col(2) = out.cross(down);
        t.add(plateau, 0.010 * u);
    }
    add_chain(t,
              {{from(knee, 0.032, 0.000, 0.000), 0.0210 * u},
               {from(knee, 0.075, -0.004, 0.008), 0.0150 * u},
               {from(knee, 0.180, -0.006, 0.006), 0.0120 * u},
               {from(ankle, -0.110, -0.006, 0.004), 0.0108 * u},
               {from(ankle, -0.030, -0.002, 0.002), 0.0150 * u},
               {from(ankle, -0.018, 0.000, 0.000), 0.0168 * u}},
              0.010 * u);
    t.add(Ellipsoid{from(knee, 0.052, 0.000, 0.022), u * Vec(0.009, 0.014, 0.008)}, 0.008 * u);  // tuberosity
    add_chain(t, {{from(ankle, -0.024, -0.014, 0.004), 0.0110 * u}, {from(ankle, 0.002, -0.0245, 0.006), 0.0070 * u}},
              0.006 * u);  // inner malleolus
    bones.push_back(std::move(tibia));

    BoneSketch fibula = start("Fibula", "left_shin", 24481, 0.0068 * u);
    add_chain(fibula.field,
              {{from(knee, 0.036, 0.034, -0.016), 0.0095 * u},
               {from(knee, 0.060, 0.032, -0.016), 0.0062 * u},
               {from(knee, 0.200, 0.026, -0.012), 0.0058 * u},
               {from(ankle, -0.090, 0.022, -0.006), 0.0060 * u},
               {from(ankle, -0.020, 0.0235, -0.004), 0.0080 * u},
               {from(ankle, 0.012, 0.0265, -0.004), 0.0068 * u}},
              0.005 * u);
    bones.push_back(std::move(fibula));
    return bones;
}

}  // namespace

std::vector<BoneSketch> limb_bone_sketches(const BodyLayout& layout)
{
    std::vector<BoneSketch> bones = shoulder_bones(layout);
    for (auto* draw : {&arm_bones, &leg_bones})
        for (BoneSketch& bone : (*draw)(layout)) bones.push_back(std::move(bone));
    return bones;
}

std::vector<BoneSketch> hand_bone_sketches(const BodyLayout& layout)
{
    const double u = layout.hand_scale();
    const Vec wrist = layout.joint("left_hand");
    const auto at = [&](double a, double s, double p) -> Vec {
        return wrist + u * (a * layout.arm_axis() + s * layout.thumb_side() + p * layout.palm_side());
    };
    std::vector<BoneSketch> bones;
    struct Carpal {
        const char* name;
        int fma_left, fma_right;
        double a, s, p, r;
    };
    constexpr std::array<Carpal, 8> carpals = {{{"Scaphoid", 24436, 24435, 0.0070, 0.0120, 0.002, 0.0078},
                                                {"Lunate", 24438, 24437, 0.0060, 0.0000, 0.000, 0.0072},
                                                {"Triquetral", 24440, 24439, 0.0080, -0.0110, 0.000, 0.0068},
                                                {"Pisiform", 24442, 24441, 0.0090, -0.0135, 0.009, 0.0048},
                                                {"Trapezium", 24444, 24443, 0.0185, 0.0180, 0.005, 0.0070},
                                                {"Trapezoid", 24445, 23725, 0.0205, 0.0095, 0.000, 0.0060},
                                                {"Capitate", 24447, 24446, 0.0190, 0.0005, 0.000, 0.0080},
                                                {"Hamate", 24449, 24448, 0.0200, -0.0105, 0.001, 0.0075}}};
    for (const Carpal& c : carpals) {
        bones.push_back(start(c.name, "left_hand", c.fma_left, 0.0042 * u, c.fma_right));
        bones.back().field.add(Ellipsoid{at(c.a, c.s, c.p), u * Vec(c.r, c.r, 0.95 * c.r)}, 0.002);
    }
    const std::array<const char*, 5> ordinals = {"First", "Second", "Third", "Fourth", "Fifth"};
    const std::array<const char*, 5> fingers = {"thumb", "index finger", "middle finger", "ring finger",
                                                "little finger"};
    const std::array<Vec, 5> bases = {at(0.022, 0.022, 0.010), at(0.028, 0.0145, 0.0), at(0.029, 0.0030, 0.0),
                                      at(0.029, -0.0070, 0.0), at(0.028, -0.0165, 0.001)};
    for (std::size_t f = 0; f < 5; ++f) {
        const Points p = finger_points(layout, static_cast<int>(f));
        const std::string finger = std::string("left_") + finger_plan(static_cast<int>(f)).name;
        const auto long_bone = [&](const std::string& name, const std::string& joint, int fma, const Vec& from,
                                   const Vec& to, double radius) {
            const Vec axis = (to - from).normalized();
            const Vec a = from + 1.25 * radius * axis, b = to - 1.25 * radius * axis, middle = 0.5 * (a + b);
            bones.push_back(start(name.c_str(), joint.c_str(), fma, 0.0042 * u));
            add_chain(bones.back().field, {{a, radius}, {middle, 0.72 * radius}, {b, 0.95 * radius}}, 0.002);
        };
        const int metacarpal = 24465 + 2 * static_cast<int>(f);
        const std::string digit = std::string(" phalanx of ") + fingers[f];
        if (f == 0) {
            long_bone("First metacarpal bone", finger + "_1", metacarpal, bases[0], p.row(1).transpose(), 0.0062 * u);
            long_bone("Proximal" + digit, finger + "_2", 0, p.row(1).transpose(), p.row(2).transpose(), 0.0055 * u);
            long_bone("Distal" + digit, finger + "_3", 0, p.row(2).transpose(), p.row(3).transpose(), 0.0045 * u);
            continue;
        }
        const double slim = f == 4 ? 0.85 : 1.0;
        long_bone(std::string(ordinals[f]) + " metacarpal bone", "left_hand", metacarpal, bases[f],
                  p.row(0).transpose(), 0.0058 * slim * u);
        long_bone("Proximal" + digit, finger + "_1", 0, p.row(0).transpose(), p.row(1).transpose(), 0.0050 * slim * u);
        long_bone("Middle" + digit, finger + "_2", 0, p.row(1).transpose(), p.row(2).transpose(), 0.0042 * slim * u);
        long_bone("Distal" + digit, finger + "_3", 0, p.row(2).transpose(), p.row(3).transpose(), 0.0034 * slim * u);
    }
    return bones;
}

std::vector<BoneSketch> foot_bone_sketches(const BodyLayout& layout)
{
    const double u = layout.foot_scale();
    const Vec ankle = layout.joint("left_foot"), below(ankle.x(), 0.0, ankle.z());
    const Vec front = layout.foot_front(), out = layout.foot_out(), up = Vec::UnitY();
    const auto at = [&](double f, double o, double h) -> Vec { return below + u * (f * front + o * out + h * up); };
    std::vector<BoneSketch> bones;
    const auto add = [&](const char* name, int fma, double f, double o, double h, double rf, double ro,
                         double rh) -> Field& {
        bones.push_back(start(name, "left_foot", fma, 0.0065 * u));
        Ellipsoid body{at(f, o, h), u * Vec(rf, ro, rh)};
        body.axes.col(0) = front;
        body.axes.col(1) = out;
        body.axes.col(2) = front.cross(out);
        bones.back().field.add(body, 0.004 * u);
        return bones.back().field;
    };
    Field& heel = add("Calcaneus", 24498, -0.030, 0.002, 0.024, 0.026, 0.0145, 0.0165);
    add_chain(heel, {{at(-0.020, 0.003, 0.024), 0.0130 * u}, {at(0.026, 0.010, 0.024), 0.0105 * u}}, 0.008 * u);
    Field& talus = add("Talus", 24483, 0.002, 0.000, 0.0530, 0.0190, 0.0165, 0.0115);
    add_chain(talus, {{at(0.010, -0.002, 0.050), 0.0105 * u}, {at(0.030, -0.007, 0.044), 0.0105 * u}}, 0.006 * u);
    add("Navicular bone", 24501, 0.044, -0.010, 0.0420, 0.0075, 0.0155, 0.0125);
    add("Cuboid bone", 24529, 0.046, 0.019, 0.0250, 0.0145, 0.0105, 0.0105);
    add("Medial cuneiform bone", 24522, 0.061, -0.018, 0.0345, 0.0100, 0.0072, 0.0120);
    add("Intermediate cuneiform bone", 24524, 0.059, -0.006, 0.0385, 0.0080, 0.0060, 0.0095);
    add("Lateral cuneiform bone", 24526, 0.060, 0.006, 0.0350, 0.0095, 0.0065, 0.0095);
    const std::array<const char*, 5> ordinals = {"First", "Second", "Third", "Fourth", "Fifth"};
    const std::array<const char*, 5> toes = {"big toe", "second toe", "third toe", "fourth toe", "little toe"};
    const std::array<Vec, 5> bases = {at(0.071, -0.019, 0.032), at(0.067, -0.007, 0.036), at(0.068, 0.005, 0.032),
                                      at(0.062, 0.016, 0.026), at(0.057, 0.026, 0.021)};
    const std::array<Vec, 5> heads = {at(0.134, -0.027, 0.0165), at(0.134, -0.0045, 0.0150), at(0.130, 0.0110, 0.0140),
                                      at(0.122, 0.0250, 0.0130), at(0.112, 0.0370, 0.0120)};
    const std::array<double, 5> toe_lengths = {0.048, 0.041, 0.037, 0.033, 0.029};
    for (std::size_t t = 0; t < 5; ++t) {
        const double radius = (t == 0 ? 0.0075 : 0.0050) * u;
        const auto long_bone = [&](const std::string& name, const char* joint, int fma, const Vec& from, const Vec& to,
                                   double r) {
            const Vec axis = (to - from).normalized();
            const Vec a = from + 1.1 * r * axis, b = to - 1.1 * r * axis;
            bones.push_back(start(name.c_str(), joint, fma, 0.0048 * u));
            add_chain(bones.back().field, {{a, r}, {0.5 * (a + b), 0.75 * r}, {b, 0.95 * r}}, 0.002);
        };
        long_bone(std::string(ordinals[t]) + " metatarsal bone", "left_foot", 24508 + 2 * static_cast<int>(t), bases[t],
                  heads[t], radius);
        const Vec tip = heads[t] + u * (toe_lengths[t] * front - 0.004 * up);
        const std::string digit = std::string(" phalanx of ") + toes[t];
        const auto along = [&](double s) -> Vec { return heads[t] + s * (tip - heads[t]); };
        if (t == 0) {
            long_bone("Proximal" + digit, "left_toes", 0, along(0.0), along(0.56), 0.0062 * u);
            long_bone("Distal" + digit, "left_toes", 0, along(0.56), along(1.0), 0.0050 * u);
        } else {
            long_bone("Proximal" + digit, "left_toes", 0, along(0.0), along(0.50), 0.0042 * u);
            long_bone("Middle" + digit, "left_toes", 0, along(0.50), along(0.76), 0.0034 * u);
            long_bone("Distal" + digit, "left_toes", 0, along(0.76), along(1.0), 0.0030 * u);
        }
    }
    return bones;
}

}  // namespace ndg
