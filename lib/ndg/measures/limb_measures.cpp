// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/measures/measured_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ndg {
namespace {

using Vec = Eigen::Vector3d;

/// stature = slope length + offset +- error, m (Trotter and Gleser 1952, American Journal of Physical Anthropology 10,
/// 463-514, white series).
struct StatureOfBone {
    double slope, offset, error;
};
struct LongBone {
    const char* name;
    StatureOfBone female, male;
};
constexpr std::array<LongBone, 6> long_bones = {{{"femur", {2.47, 0.5410, 0.0372}, {2.38, 0.6141, 0.0327}},
                                                 {"tibia", {2.90, 0.6153, 0.0366}, {2.52, 0.7862, 0.0337}},
                                                 {"fibula", {2.93, 0.5961, 0.0357}, {2.68, 0.7178, 0.0329}},
                                                 {"humerus", {3.36, 0.5797, 0.0445}, {3.08, 0.7045, 0.0405}},
                                                 {"radius", {4.74, 0.5493, 0.0424}, {3.78, 0.7901, 0.0432}},
                                                 {"ulna", {4.27, 0.5776, 0.0430}, {3.70, 0.7405, 0.0432}}}};

/// The length that tells the stature, and how far lengths may lie from it where they tell one standard error more.
Spread length_of(const StatureOfBone& bone, double stature_m)
{
    return {(stature_m - bone.offset) / bone.slope, bone.error / bone.slope};
}

/// The two vertices farthest apart, as far as going from one to its farthest and back finds them.
std::array<Vec, 2> ends_of(const Points& vertices)
{
    std::array<Vec, 2> ends = {farthest(vertices, Vec::UnitY()), farthest(vertices, -Vec::UnitY())};
    for (int round = 0; round < 8; ++round) {
        const std::array<Vec, 2> before = ends;
        for (const int k : {0, 1}) {
            Eigen::Index found = 0;
            (vertices.rowwise() - ends[1 - k].transpose()).rowwise().squaredNorm().maxCoeff(&found);
            ends[k] = vertices.row(found).transpose();
        }
        if (before == ends) break;
    }
    return ends;
}

/// Unit axis between the ends, upwards.
Vec long_axis(const Points& vertices)
{
    const std::array<Vec, 2> ends = ends_of(vertices);
    return (ends[0].y() > ends[1].y() ? ends[0] - ends[1] : ends[1] - ends[0]).normalized();
}

/// Extent along a unit direction.
double breadth_along(const Points& vertices, const Vec& direction)
{
    const Eigen::VectorXd along = vertices * direction;
    return along.maxCoeff() - along.minCoeff();
}

/// Greatest extent of all directions across a unit axis.
double breadth_across(const Points& vertices, const Vec& axis)
{
    const Vec u = axis.unitOrthogonal(), w = axis.cross(u);
    double greatest = 0.0;
    constexpr int directions = 36;
    for (int k = 0; k < directions; ++k) {
        const double angle = M_PI * k / directions;
        greatest = std::max(greatest, breadth_along(vertices, std::cos(angle) * u + std::sin(angle) * w));
    }
    return greatest;
}

/// Length of a tibia as Trotter took it, without the eminence between the condyles and without the malleolus (Jantz,
/// Hunt and Meadows 1995, Journal of Forensic Sciences 40, 758-761): from the condyles, mean of inner and outer quarter
/// of the upper end, to the outer half of the lower end. `lateral`: sign of x on the outer side.
double tibia_length(const Points& vertices, double lateral)
{
    const Vec axis = long_axis(vertices), outward(lateral, 0.0, 0.0);
    const Points upper = between_shares(vertices, axis, 0.9, 1.0), lower = between_shares(vertices, axis, 0.0, 0.1);
    return 0.5 * ((between_shares(upper, outward, 0.0, 0.25) * axis).maxCoeff() +
                  (between_shares(upper, outward, 0.75, 1.0) * axis).maxCoeff()) -
           (between_shares(lower, outward, 0.5, 1.0) * axis).minCoeff();
}

/// Length of a long bone: between the vertices farthest apart, but for the tibia.
double length(const std::string& bone, const Points& vertices, double lateral)
{
    if (bone == "tibia") return tibia_length(vertices, lateral);
    const std::array<Vec, 2> ends = ends_of(vertices);
    return (ends[0] - ends[1]).norm();
}

/// Diameter of the femur's head; no number for a bone without a round one.
double head_diameter(const Points& femur, double lateral)
{
    try {
        // Half of 46 +- 5 mm (Noble et al. 1988).
        return 2.0 * head_sphere(femur, Vec(-1.2 * lateral, 1.0, 0.0), 0.023).radius;
    } catch (const Error&) {
        return std::numeric_limits<double>::quiet_NaN();
    }
}

/// A measure of both sides: mean and relative difference.
struct Pair {
    double left, right;
    double mean() const { return 0.5 * (left + right); }
    double difference() const { return std::abs(left - right) / mean(); }
};
template <typename Measure>
Pair both(const MeasuredBones& body, const std::string& bone, const Measure& measure)
{
    return {measure(body.bone("left " + bone), 1.0), measure(body.bone("right " + bone), -1.0)};
}
bool has_pair(const MeasuredBones& body, const std::string& bone)
{
    return body.has({"left " + bone, "right " + bone});
}

void add_lengths(const MeasuredBones& body, MeasureTable& table)
{
    double worst = 0.0;
    std::string worst_bone;
    for (const LongBone& bone : long_bones) {
        if (!has_pair(body, bone.name)) continue;
        const Pair lengths =
            both(body, bone.name, [&](const Points& v, double lateral) { return length(bone.name, v, lateral); });
        table.add_gate(
            {fmt::format("{}, length", bone.name), "greatest length (tibia: without eminence and malleolus), mean",
             MeasureUnit::millimetre, "the stature it tells is the body's within 3 errors, Trotter 1952"},
            lengths.mean(), length_of(bone.female, body.stature_m), length_of(bone.male, body.stature_m));
        if (lengths.difference() < worst) continue;
        worst = lengths.difference();
        worst_bone = bone.name;
    }
    if (!worst_bone.empty())
        table.add({"long bones, left to right", "greatest relative difference of their lengths"}, worst);
    if (!has_pair(body, "femur") || !has_pair(body, "tibia")) return;
    const auto leg = [&](const std::string& side, double lateral) {
        return length("femur", body.bone(side + " femur"), lateral) +
               length("tibia", body.bone(side + " tibia"), lateral);
    };
    table.add_gate({"legs, left to right", "difference of femur and tibia together", MeasureUnit::millimetre,
                    "5.2 +- 4.1, 573 adults, Knutson 2005"},
                   std::abs(leg("left", 1.0) - leg("right", -1.0)), 0.0, 0.0052 + 3.0 * 0.0041);
}

void add_breadths(const MeasuredBones& body, MeasureTable& table)
{
    const auto row = [](const std::string& name, const std::string& method, const std::string& source) {
        return MeasureTable::Row{name, method, MeasureUnit::millimetre, source};
    };
    if (has_pair(body, "femur")) {
        const Pair head = both(body, "femur", head_diameter);
        table.add_gate(row("femoral head, diameter", "sphere through its surface, mean of both sides",
                           "46 +- 5, Noble 1988; 43.3 F, 48.5 M, Cho 2015"),
                       head.mean(), Spread{0.046, 0.005}, Spread{0.046, 0.005});
        const Pair knee = both(body, "femur", [](const Points& v, double) {
            return breadth_along(between_shares(v, Vec::UnitY(), 0.0, 0.12), Vec::UnitX());
        });
        // Three published means with their deviations; the range holds all of them.
        table.add_gate(row("femur, epicondylar breadth", "breadth of the lower eighth, mean of both sides",
                           "72.5 +- 3.5 to 78.5 +- 3.0 F, 82.7 +- 4.0 to 88.6 +- 4.2 M; Kapur, Terzidis 2012"),
                       knee.mean(), Spread{0.0755, 0.0044}, Spread{0.0857, 0.0051});
    }
    if (has_pair(body, "tibia")) {
        const Pair plateau = both(body, "tibia", [](const Points& v, double) {
            return breadth_along(between_shares(v, Vec::UnitY(), 0.9, 1.0), Vec::UnitX());
        });
        table.add_compared(row("tibial plateau, breadth", "breadth of the upper tenth, mean of both sides",
                               "66.1 to 71.7 F, 75.2 to 83.0 M with 3 to 6, PMC9703208"),
                           plateau.mean(), Spread{0.0690, 0.0050}, Spread{0.0790, 0.0060});
    }
    if (has_pair(body, "humerus")) {
        const Pair elbow = both(body, "humerus", [](const Points& v, double) {
            const Vec axis = long_axis(v);
            return breadth_across(between_shares(v, axis, 0.0, 0.12), axis);
        });
        table.add(row("humerus, epicondylar breadth", "breadth of the lower eighth, mean of both sides", ""),
                  elbow.mean());
    }
}

void add_covers(const MeasuredBones& body, MeasureTable& table)
{
    const auto cover = [&](const std::string& name, const std::string& method, const std::string& bone, double low,
                           double high) {
        if (!has_pair(body, bone)) return;
        const Pair depths = both(body, bone, [&](const Points& v, double) {
            return body.cover(between_shares(v, long_axis(v), low, high));
        });
        table.add({name, method + ", mean of both sides", MeasureUnit::millimetre}, depths.mean());
    };
    if (has_pair(body, "femur")) {
        const Pair trochanter = both(body, "femur", [&](const Points& v, double lateral) {
            return body.depth(farthest(between_shares(v, Vec::UnitY(), 0.75, 1.0), Vec(lateral, 0.0, 0.0)));
        });
        table.add_compared(
            {"greater trochanter, depth", "outermost point of the femur's upper quarter, mean of both sides",
             MeasureUnit::millimetre, "31.0 +- 11.5, DXA of older men, Nielson; grows with BMI, more in women"},
            trochanter.mean(), Spread{0.0310, 0.0115}, Spread{0.0310, 0.0115});
    }
    cover("shin, least depth", "middle half of the tibia", "tibia", 0.25, 0.75);
    cover("patella, least depth", "of the whole bone", "patella", 0.0, 1.0);
    cover("medial malleolus, least depth", "lower twentieth of the tibia", "tibia", 0.0, 0.05);
    cover("lateral malleolus, least depth", "lower tenth of the fibula", "fibula", 0.0, 0.1);
    cover("olecranon, least depth", "upper tenth of the ulna", "ulna", 0.9, 1.0);
}

/// Paired bones whose middle lies on the other side's half of the body.
void add_sides(const MeasuredBones& body, MeasureTable& table)
{
    const double pelvis = body.joint("pelvis").x();
    int wrong = 0, paired = 0;
    for (const AnatomyMesh& bone : body.meshes) {
        if (bone.side == BodySide::middle) continue;
        ++paired;
        wrong += (middle(bone.vertices).x() > pelvis) != (bone.side == BodySide::left);
    }
    if (paired > 0)
        table.add_gate({"bones on the other side", "paired bones whose middle is not on the side they are named after",
                        MeasureUnit::number, "left is +x"},
                       wrong, 0.0, 0.0);
}

}  // namespace

void add_limb_measures(const MeasuredBones& body, MeasureTable& table)
{
    add_sides(body, table);
    add_lengths(body, table);
    add_breadths(body, table);
    add_covers(body, table);
}

}  // namespace ndg
