// SPDX-License-Identifier: Apache-2.0
#include "ndg/measures/measured_parts.h"

#include <algorithm>

namespace ndg {

void add_joint_measures(const MeasuredSkin& body, MeasureTable& table)
{
    const auto both_sides = [&](const auto& measure) { return 0.5 * (measure("left_") + measure("right_")); };
    const auto distance = [&](const std::string& a, const std::string& b) {
        return (body.joint(a) - body.joint(b)).norm();
    };
    const auto segment = [&](const std::string& a, const std::string& b) {
        return both_sides([&](const std::string& side) { return distance(side + a, side + b); }) / body.stature_m;
    };
    const auto height = [&](const std::string& joint) {
        return both_sides([&](const std::string& side) { return body.joint(side + joint).y() - body.floor_m; }) /
               body.stature_m;
    };
    const char* const over_stature = "over stature";
    // The joints lie below the acromia or nearer to the middle: biacromial breadth bounds them above.
    MeasureTable::Row shoulders{"shoulder joints apart", over_stature, MeasureUnit::number,
                                "people 0.18 to 0.22; below biacromial breadth, ANSUR II, Gordon 2014"};
    table.add_gate(shoulders, distance("left_upper_arm", "right_upper_arm") / body.stature_m, 0.18,
                   table.range({0.224, 0.010}, {0.237, 0.010}).second);
    table.add({"hip joints apart", over_stature}, distance("left_thigh", "right_thigh") / body.stature_m);
    table.add_gate({"hip joint, height", "over stature; against the trochanterion's", MeasureUnit::number,
                    "0.519 +- 0.014 F, 0.513 +- 0.015 M, ANSUR II, Gordon 2014"},
                   height("thigh"), Spread{0.519, 0.014}, Spread{0.513, 0.015});
    table.add_gate({"knee joint, height", "over stature; against the lateral epicondyle's", MeasureUnit::number,
                    "0.286 +- 0.010 F, 0.280 +- 0.008 M, ANSUR II, Gordon 2014"},
                   height("shin"), Spread{0.286, 0.010}, Spread{0.280, 0.008});
    table.add({"ankle joint, height", "over stature; 0.039 F and 0.042 M at the lateral malleolus"}, height("foot"));
    table.add({"upper arm", "shoulder to elbow joint over stature"}, segment("upper_arm", "forearm"));
    table.add({"forearm", "elbow to wrist joint over stature"}, segment("forearm", "hand"));
    table.add({"thigh", "hip to knee joint over stature"}, segment("thigh", "shin"));
    table.add({"shank", "knee to ankle joint over stature"}, segment("shin", "foot"));
    // Joints mirrored in the plane through the pelvis.
    const double pelvis = body.joint("pelvis").x();
    double worst = 0.0;
    for (const std::string& name : body.body_template.skeleton.joint_names) {
        if (name.rfind("left_", 0) != 0) continue;
        Eigen::Vector3d left = body.joint(name);
        left.x() = 2.0 * pelvis - left.x();
        worst = std::max(worst, (left - body.joint("right_" + name.substr(5))).norm());
    }
    table.add({"joints, left to right", "greatest distance of a joint from the other side's, mirrored",
               MeasureUnit::millimetre},
              worst);
}

}  // namespace ndg
