// SPDX-License-Identifier: Apache-2.0
// What the groups of measures share: a body's bones and skin, ready to be asked.
#pragma once

#include "ndg/body_source/bone_parts.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/measures/body_measure.h"

#include <vector>

namespace ndg {

/// A skin with its joints.
struct MeasuredSkin {
    MeasuredSkin(const Template& measured_template, const Skin& measured_skin);

    const Template& body_template;
    const Skin& skin;
    double stature_m = 0, floor_m = 0, mass_kg = 0, bmi = 0;
    TriangleTree surface;

    Eigen::Vector3d joint(const std::string& name) const;
    /// m under the skin; negative outside.
    double depth(const Eigen::Vector3d& point) const { return -surface.signed_distance(point); }
    /// Least depth of the points, m.
    double cover(const Points& points) const;
};

/// A body with its bones.
struct MeasuredBones : MeasuredSkin {
    MeasuredBones(const Template& measured_template, const Body& measured_body);

    const Body& body;
    Points anatomy;  ///< N_a x 3
    std::vector<AnatomyMesh> meshes;
    PartFinder bones;

    /// Whether all these bones are there.
    bool has(const std::vector<std::string>& names) const;
    const Points& bone(const std::string& name) const { return bones.part(name).vertices; }
};

/// Vertices whose height along `axis` (of any length) lies between shares of the extent along it, 0 at its low end.
Points between_shares(const Points& vertices, const Eigen::Vector3d& axis, double low, double high);

void add_joint_measures(const MeasuredSkin& body, MeasureTable& table);
void add_spine_measures(const MeasuredBones& body, MeasureTable& table);
void add_trunk_measures(const MeasuredBones& body, MeasureTable& table);
void add_limb_measures(const MeasuredBones& body, MeasureTable& table);
void add_flesh_measures(const MeasuredBones& body, MeasureTable& table);

/// Name of the row that common_failures averages.
constexpr const char* hip_centre_measure = "hip joints, distance from regression";

}  // namespace ndg
