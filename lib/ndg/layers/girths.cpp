// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/girths.h"

#include "ndg/core/error.h"
#include "ndg/geometry/section_hull.h"

#include <algorithm>
#include <string>
#include <vector>

namespace ndg {
namespace {

/// Planes through a body's skin.
class Tape {
public:
    Tape(const Template& body_template, const Skin& skin) : template_(body_template), skin_(skin) {}

    Eigen::Vector3d joint(const std::string& name) const
    {
        return skin_.joint_positions.row(template_.skeleton.joint(name)).transpose();
    }
    Eigen::Vector3d landmark(const std::string& name) const
    {
        for (const Landmark& landmark : template_.landmarks) {
            if (landmark.name != name) continue;
            Eigen::Vector3d place = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k)
                place += landmark.barycentric[k] *
                         skin_.skin_vertices.row(template_.skin_triangles(landmark.skin_triangle_idx, k)).transpose();
            return place;
        }
        throw InputError("the template has no landmark '" + name + "', which girths are measured at");
    }
    double girth(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, const char* what) const
    {
        const double result = section_girth(skin_.skin_vertices, template_.skin_triangles, centre, normal);
        require_input(result > 0.0,
                      "body {}: no {} girth: the plane through ({:.3f}, {:.3f}, {:.3f}) m misses the skin", skin_.name,
                      what, centre[0], centre[1], centre[2]);
        return result;
    }
    /// Girths across the way between two places, at shares from `low` to `high` of it.
    std::vector<double> girths(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double low, double high,
                               int count, const char* what) const
    {
        std::vector<double> result;
        for (int i = 0; i < count; ++i) {
            const double share = count == 1 ? low : low + (high - low) * i / (count - 1);
            result.push_back(girth(from + share * (to - from), to - from, what));
        }
        return result;
    }
    double horizontal(double height, const char* what) const
    {
        // The trunk's middle at that height, on the line from pelvis to the root of the neck.
        const Eigen::Vector3d low = joint("pelvis"), high = joint("neck_1");
        Eigen::Vector3d centre = low + (height - low[1]) / (high[1] - low[1]) * (high - low);
        centre[1] = height;
        return girth(centre, Eigen::Vector3d::UnitY(), what);
    }

private:
    const Template& template_;
    const Skin& skin_;
};

double largest(const std::vector<double>& values)
{
    return *std::max_element(values.begin(), values.end());
}
double smallest(const std::vector<double>& values)
{
    return *std::min_element(values.begin(), values.end());
}

}  // namespace

double section_girth(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                     const Eigen::Vector3d& centre, const Eigen::Vector3d& normal)
{
    return section_hull(vertices, triangles, centre, normal).girth();
}

BodyGirths measure_girths(const Template& body_template, const Skin& skin)
{
    const Tape tape(body_template, skin);
    BodyGirths girths;
    girths.neck = smallest(tape.girths(tape.joint("neck_1"), tape.joint("head"), 0.1, 0.9, 9, "neck"));
    const double navel = tape.landmark("navel")[1], notch = tape.landmark("suprasternale")[1];
    girths.abdomen = tape.horizontal(navel, "abdomen");
    // The lower end of the breast bone lies about halfway from navel to jugular notch.
    girths.waist = girths.abdomen;
    for (int i = 1; i <= 8; ++i)
        girths.waist = std::min(girths.waist, tape.horizontal(navel + 0.5 * i / 8.0 * (notch - navel), "waist"));
    girths.hip = tape.horizontal(0.5 * (tape.landmark("left_buttock")[1] + tape.landmark("right_buttock")[1]), "hip");
    for (const std::string side : {"left_", "right_"}) {
        const Eigen::Vector3d shoulder = tape.joint(side + "upper_arm"), elbow = tape.joint(side + "forearm");
        const Eigen::Vector3d wrist = tape.joint(side + "hand"), hip = tape.joint(side + "thigh");
        const Eigen::Vector3d knee = tape.joint(side + "shin"), ankle = tape.joint(side + "foot");
        girths.upper_arm += 0.5 * tape.girths(shoulder, elbow, 0.5, 0.5, 1, "upper arm").front();
        girths.forearm += 0.5 * largest(tape.girths(elbow, wrist, 0.1, 0.5, 7, "forearm"));
        girths.thigh += 0.5 * tape.girths(hip, knee, 0.5, 0.5, 1, "thigh").front();
        girths.calf += 0.5 * largest(tape.girths(knee, ankle, 0.15, 0.6, 7, "calf"));
    }
    return girths;
}

}  // namespace ndg
