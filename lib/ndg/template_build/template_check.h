// SPDX-License-Identifier: Apache-2.0
// What a template has to hold before anything is simulated with it, and its measures.
#pragma once

#include "ndg/body/template.h"
#include "ndg/measures/segment_measures.h"

#include <array>
#include <string>
#include <vector>

namespace ndg {

/// The gates of a template.
struct TemplateGates {
    double min_scaled_jacobian = 0.05;
    double containment = 0.999;       ///< share of anatomy vertices inside their wrap
    double embedding_limit = 0.0005;  ///< m; every volumetric vertex lies in an element or this near to one
};

struct JacobianCheck {
    int num_invalid = 0;              ///< prisms with a Jacobian <= 0 at a corner or quadrature point
    double min_scaled = 0;            ///< smallest scaled Jacobian
    std::array<int, 10> histogram{};  ///< prisms with a scaled Jacobian in [0, 0.1), ..., [0.9, 1]; invalid ones first
};

struct Thickness {
    double min = 0, mean = 0, max = 0;  ///< m, of one layer along its vertical edges
};

/// A part and how far its worst vertex lies off where it should be, m.
struct PartDistance {
    std::string part;
    double distance = 0;
};

struct Containment {
    int num_vertices = 0, num_outside = 0;  ///< volumetric vertices of a layer, and those outside the closed wrap
    double worst_excess = 0;                ///< m
    std::vector<PartDistance> worst;        ///< parts with vertices outside, worst first
    double share() const { return num_vertices == 0 ? 1.0 : 1.0 - double(num_outside) / num_vertices; }
};

struct Coverage {
    int num_volumetric = 0, num_skinned = 0;  ///< anatomy vertices embedded, and moved by skinning beyond the cuts
    int num_inside = 0, num_near = 0, num_far = 0;  ///< within rounding of an element, within the limit, farther
    std::vector<PartDistance> worst;                ///< parts with far vertices, worst first
};

struct WeightCheck {
    double worst_row_sum = 0;  ///< |sum - 1| of the rows of skin, interior and anatomy
    double min_weight = 0, max_weight = 0;
    int num_joints_used = 0;
    std::vector<std::string> unused_joints;
};

struct TemplateCheck {
    TemplateGates gates;
    int skin_vertices = 0, skin_triangles = 0, wrap_vertices = 0, wrap_triangles = 0, prisms = 0, tetrahedra = 0,
        interior_vertices = 0, anatomy_vertices = 0, bones = 0, muscles = 0, landmarks = 0;
    std::string skin_defect;           ///< empty for a closed outward manifold
    std::string wrap_defect;           ///< empty where each wrap, closed over its cuts, is one too
    std::vector<int> border_vertices;  ///< of each border of the wraps
    JacobianCheck muscle_jacobians, fat_jacobians;
    int num_flat_tetrahedra = 0;                        ///< with volume <= 0
    int skin_self = 0, muscle_self = 0, bone_self = 0;  ///< pairs of intersecting triangles
    int skin_muscle = 0, muscle_bone = 0, skin_bone = 0;
    Thickness muscle_thickness, fat_thickness;
    Containment bones_inside, muscles_inside;
    Coverage coverage;
    WeightCheck weights;
    std::vector<PartDistance> joints_outside;  ///< joints outside the skin
    double stature = 0, skin_volume = 0;       ///< m, m^3
    std::vector<SegmentMeasure> segments;      ///< the last one is the whole body
    double worst_asymmetry = 0;                ///< largest left-right difference of a segment's volume, share
    std::string worst_asymmetry_segment;

    int num_intersections() const;
    /// The gates that do not hold, one sentence each; none: the template passes.
    std::vector<std::string> failures() const;
    bool passes() const { return failures().empty(); }
};

/// Checks the template as its file stores it, that is with positions rounded to float32.
TemplateCheck check_template(const Template& body_template, const TemplateGates& gates = {});

/// The check as text, several lines.
std::string template_report(const TemplateCheck& check);

}  // namespace ndg
