// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/measures/measured_parts.h"
#include "ndg/measures/segment_measures.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

namespace ndg {
namespace {

using Vec = Eigen::Vector3d;

/// Where on a body thickness is averaged: wrap vertices that hang on `joints` most, by their place and the direction
/// their skin faces.
struct Region {
    std::string name;
    std::vector<std::string> joints;
    std::function<bool(const Vec& point, const Vec& normal)> where;
    std::string fat_source = {}, muscle_source = {};
};

/// The skin's landmark of that name; false if the template has none.
bool landmark(const MeasuredBones& body, const std::string& name, Vec& point)
{
    for (const Landmark& candidate : body.body_template.landmarks) {
        if (candidate.name != name) continue;
        point.setZero();
        for (int k = 0; k < 3; ++k)
            point += candidate.barycentric[k] *
                     body.skin.skin_vertices.row(body.body_template.skin_triangles(candidate.skin_triangle_idx, k))
                         .transpose();
        return true;
    }
    return false;
}

std::vector<Region> regions_of(const MeasuredBones& body)
{
    const double band = 0.025 * body.stature_m;  // half the height of a region
    const auto facing = [band](double height, double direction) {
        return [=](const Vec& point, const Vec& normal) {
            return std::abs(point.y() - height) < band && direction * normal.z() > 0.7;
        };
    };
    std::vector<Region> regions;
    const std::vector<std::string> trunk = {"pelvis",  "spine_1", "spine_2",       "spine_3",       "spine_4",
                                            "spine_5", "neck_1",  "left_clavicle", "right_clavicle"};
    Vec point;
    if (landmark(body, "left_nipple", point)) {
        regions.push_back({"chest, front", trunk, facing(point.y(), 1.0), "fat 10 at the nipples, 36.5 at BMI 46"});
        regions.push_back({"chest, back", trunk, facing(point.y(), -1.0), "fat 17 at that level, 50.7 at BMI 46"});
    }
    if (landmark(body, "navel", point)) {
        regions.push_back({"belly", trunk, facing(point.y(), 1.0)});
        regions.push_back({"small of the back", trunk, facing(point.y(), -1.0)});
    }
    if (landmark(body, "left_buttock", point)) {
        std::vector<std::string> joints = trunk;
        joints.insert(joints.end(), {"left_thigh", "right_thigh"});
        regions.push_back({"buttocks", joints, facing(point.y(), -1.0)});
    }
    const double hip = body.joint("left_thigh").y(), knee = body.joint("left_shin").y(),
                 ankle = body.joint("left_foot").y();
    const std::vector<std::string> thigh = {"left_thigh", "right_thigh"}, shin = {"left_shin", "right_shin"};
    regions.push_back({"thigh, front", thigh, facing(0.5 * (hip + knee), 1.0), "10.4 +- 4.1, 39 to 66 years, Mechelli",
                       "28.0 +- 7.1, 39 to 66 years, Mechelli; 46.0 +- 5.6 F, 18 to 25 years, Yasuda 2020"});
    regions.push_back(
        {"thigh, back", thigh, facing(0.5 * (hip + knee), -1.0), "", "54.0 +- 4.9 F, 18 to 25 years, Yasuda 2020"});
    regions.push_back(
        {"calf", shin, facing(0.7 * knee + 0.3 * ankle, -1.0), "", "60.3 +- 5.1 F, 18 to 25 years, Yasuda 2020"});
    // Arms stand away from the trunk at rest: their middle by the distance from shoulder and elbow.
    for (const double direction : {1.0, -1.0})
        regions.push_back(
            {direction > 0.0 ? "upper arm, front" : "upper arm, back",
             {"left_upper_arm", "right_upper_arm"},
             [&body, band, direction](const Vec& p, const Vec& normal) {
                 const std::string side = p.x() > body.joint("pelvis").x() ? "left_" : "right_";
                 const Vec shoulder = body.joint(side + "upper_arm"), elbow = body.joint(side + "forearm");
                 const double along = (p - shoulder).dot((elbow - shoulder).normalized());
                 return std::abs(along - 0.5 * (elbow - shoulder).norm()) < band && direction * normal.z() > 0.7;
             }});
    return regions;
}

void add_thicknesses(const MeasuredBones& body, MeasureTable& table)
{
    const Template& t = body.body_template;
    const int n = t.num_wrap_vertices();
    const Points bone = body.body.volume_vertices.topRows(n), muscle = body.body.volume_vertices.middleRows(n, n),
                 skin = body.body.volume_vertices.bottomRows(n);
    const Points normals = vertex_normals(skin, t.wrap_triangles);
    const Eigen::VectorXd areas = vertex_areas(skin, t.wrap_triangles), fat = (skin - muscle).rowwise().norm(),
                          flesh = (muscle - bone).rowwise().norm();
    table.add(
        {"fat layer, mean", "thickness between muscle wrap and skin over the whole body", MeasureUnit::millimetre},
        areas.dot(fat) / areas.sum());
    for (const Region& region : regions_of(body)) {
        std::vector<char> counts(t.skeleton.num_joints(), 0);
        for (const std::string& joint : region.joints) counts[t.skeleton.joint(joint)] = 1;
        double area = 0.0, fat_sum = 0.0, flesh_sum = 0.0;
        for (int w = 0; w < n; ++w) {
            const int v = t.wrap_to_skin[w];
            int most = 0;
            t.skin_weights.weights.row(v).maxCoeff(&most);
            if (!counts[t.skin_weights.joints(v, most)]) continue;
            if (!region.where(skin.row(w).transpose(), normals.row(w).transpose())) continue;
            area += areas[w];
            fat_sum += areas[w] * fat[w];
            flesh_sum += areas[w] * flesh[w];
        }
        if (area == 0.0) continue;
        table.add({"fat, " + region.name, "muscle wrap to skin, mean of the region", MeasureUnit::millimetre,
                   region.fat_source},
                  fat_sum / area);
        table.add({"muscle, " + region.name, "bone wrap to muscle wrap, mean of the region", MeasureUnit::millimetre,
                   region.muscle_source},
                  flesh_sum / area);
    }
}

/// Share of the mass by de Leva 1996 (Journal of Biomechanics 29, 1223-1230); deviations: Zatsiorsky's men.
struct SegmentShare {
    const char* name;
    std::vector<std::string> segments;
    Spread female, male;
};

void add_masses(const MeasuredBones& body, MeasureTable& table)
{
    const std::vector<SegmentMeasure> segments = segment_measures(body.body_template, body.body, body.anatomy);
    const double whole = segments.back().mass;
    if (!(whole > 0.0)) return;
    table.add({"mass of tissues over volume's", "sum of tissues over volume times 1010 kg/m^3"}, whole / body.mass_kg);
    const std::vector<SegmentShare> shares = {
        {"head and neck", {"head"}, {0.0668, 0.0071}, {0.0694, 0.0071}},
        {"trunk", {"trunk"}, {0.4257, 0.0456}, {0.4346, 0.0456}},
        {"upper arm", {"left_upper_arm", "right_upper_arm"}, {0.0255, 0.0024}, {0.0271, 0.0024}},
        {"forearm", {"left_forearm", "right_forearm"}, {0.0138, 0.0014}, {0.0162, 0.0014}},
        {"hand", {"left_hand", "right_hand"}, {0.0056, 0.0008}, {0.0061, 0.0008}},
        {"thigh", {"left_thigh", "right_thigh"}, {0.1478, 0.0100}, {0.1416, 0.0100}},
        {"shank", {"left_shin", "right_shin"}, {0.0481, 0.0031}, {0.0433, 0.0031}},
        {"foot", {"left_foot", "right_foot"}, {0.0129, 0.0016}, {0.0137, 0.0016}}};
    for (const SegmentShare& share : shares) {
        double mass = 0.0;
        for (const SegmentMeasure& segment : segments)
            for (const std::string& name : share.segments) mass += segment.name == name ? segment.mass : 0.0;
        // Our segments end where joints take over, de Leva's thigh and trunk elsewhere: no gate.
        table.add_compared(
            {fmt::format("{}, share of mass", share.name), "tissues that hang on the segment most, one side",
             MeasureUnit::number, "de Leva 1996, Zatsiorsky; cut differently"},
            mass / double(share.segments.size()) / whole, share.female, share.male);
    }
    std::string which;
    table.add({"segments, left to right", "greatest relative difference of their volumes"},
              worst_asymmetry(segments, which));
}

}  // namespace

void add_flesh_measures(const MeasuredBones& body, MeasureTable& table)
{
    add_thicknesses(body, table);
    add_masses(body, table);
}

}  // namespace ndg
