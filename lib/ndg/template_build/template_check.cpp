// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/template_check.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/wraps/bone_interior.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace ndg {
namespace {

/// Float32 positions of a body two metres high are this exact; nearer counts as inside.
constexpr double rounding = 1e-6;

Points rounded(const Points& points)
{
    return points.cast<float>().cast<double>();
}

Template as_stored(Template body_template)
{
    for (Points* points :
         {&body_template.rest.skin_vertices, &body_template.rest.volume_vertices, &body_template.rest.interior_vertices,
          &body_template.rest.joint_positions, &body_template.anatomy_vertices})
        *points = rounded(*points);
    return body_template;
}

/// Worst distance of each part, worst first.
std::vector<PartDistance> sorted_parts(const std::map<std::string, double>& worst_of_part)
{
    std::vector<PartDistance> parts;
    for (const auto& [part, distance] : worst_of_part) parts.push_back({part, distance});
    std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.distance > b.distance; });
    return parts;
}

void check_jacobians(const Template& body_template, TemplateCheck& check)
{
    for (JacobianCheck* layer : {&check.muscle_jacobians, &check.fat_jacobians}) layer->min_scaled = 1.0;
    for (Eigen::Index p = 0; p < body_template.num_prisms(); ++p) {
        JacobianCheck& layer = p < body_template.fat_begin() ? check.muscle_jacobians : check.fat_jacobians;
        const PrismVertices prism = gather_prism(body_template.rest.volume_vertices, body_template.prisms, p);
        const double scaled = prism_min_scaled_jacobian(prism);
        layer.num_invalid += prism_min_jacobian(prism) <= 0.0 ? 1 : 0;
        layer.min_scaled = std::min(layer.min_scaled, scaled);
        ++layer.histogram[std::clamp(std::floor(10.0 * scaled), 0.0, 9.0)];
    }
    const int num_wrap = body_template.num_wrap_vertices();
    Points tetrahedron_vertices(num_wrap + body_template.rest.interior_vertices.rows(), 3);
    tetrahedron_vertices << body_template.rest.volume_vertices.topRows(num_wrap), body_template.rest.interior_vertices;
    const Eigen::VectorXd volumes = tetrahedron_volumes(tetrahedron_vertices, body_template.tetrahedra);
    check.num_flat_tetrahedra = static_cast<int>((volumes.array() <= 0.0).count());
}

void check_surfaces(const Template& body_template, TemplateCheck& check)
{
    const Points& skin = body_template.rest.skin_vertices;
    const int n = body_template.num_wrap_vertices();
    const Points bone = body_template.rest.volume_vertices.topRows(n),
                 muscle = body_template.rest.volume_vertices.middleRows(n, n);
    const Triangles& wrap = body_template.wrap_triangles;
    check.skin_defect = closed_surface_defect(skin, body_template.skin_triangles);
    for (const auto& loop : boundary_loops(wrap, n)) check.border_vertices.push_back(static_cast<int>(loop.size()));
    const char* const names[] = {"bone wrap", "muscle wrap", "volumetric skin"};
    for (int layer = 0; layer < 3 && check.wrap_defect.empty(); ++layer) {
        const ClosedBoneWrap closed =
            close_bone_wrap(body_template.rest.volume_vertices.middleRows(layer * n, n), wrap);
        const std::string defect = closed_surface_defect(closed.vertices, closed.triangles);
        if (!defect.empty()) check.wrap_defect = fmt::format("{}: {}", names[layer], defect);
    }
    check.skin_self = static_cast<int>(self_intersections(skin, body_template.skin_triangles, true).size());
    check.muscle_self = static_cast<int>(self_intersections(muscle, wrap, true).size());
    check.bone_self = static_cast<int>(self_intersections(bone, wrap, true).size());
    check.skin_muscle =
        static_cast<int>(surface_intersections(skin, body_template.skin_triangles, muscle, wrap).size());
    check.muscle_bone = static_cast<int>(surface_intersections(muscle, wrap, bone, wrap).size());
    check.skin_bone = static_cast<int>(surface_intersections(skin, body_template.skin_triangles, bone, wrap).size());

    const auto thickness = [&](int inner, int outer) {
        const Eigen::VectorXd distance = (body_template.rest.volume_vertices.middleRows(outer * n, n) -
                                          body_template.rest.volume_vertices.middleRows(inner * n, n))
                                             .rowwise()
                                             .norm();
        return n == 0 ? Thickness{} : Thickness{distance.minCoeff(), distance.mean(), distance.maxCoeff()};
    };
    check.muscle_thickness = thickness(0, 1);
    check.fat_thickness = thickness(1, 2);
}

/// Whether volumetric vertices of the layer's parts lie inside a wrap closed over its cuts.
Containment containment(const Template& body_template, AnatomyLayer layer, int wrap)
{
    const int n = body_template.num_wrap_vertices();
    const ClosedBoneWrap closed =
        close_bone_wrap(body_template.rest.volume_vertices.middleRows(wrap * n, n), body_template.wrap_triangles);
    const TriangleTree tree(closed.vertices, closed.triangles);
    Containment result;
    std::map<std::string, double> worst;
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != layer) continue;
        Eigen::VectorXd excess = Eigen::VectorXd::Zero(part.vertex_end - part.vertex_begin);
#pragma omp parallel for schedule(static)
        for (int v = part.vertex_begin; v < part.vertex_end; ++v)
            if (body_template.embedding.elements[v] >= 0)
                excess[v - part.vertex_begin] = tree.signed_distance(body_template.anatomy_vertices.row(v).transpose());
        for (int v = part.vertex_begin; v < part.vertex_end; ++v)
            result.num_vertices += body_template.embedding.elements[v] >= 0 ? 1 : 0;
        result.num_outside += static_cast<int>((excess.array() > rounding).count());
        if (excess.size() > 0 && excess.maxCoeff() > rounding)
            worst[part.name] = std::max(worst[part.name], excess.maxCoeff());
    }
    result.worst = sorted_parts(worst);
    if (!result.worst.empty()) result.worst_excess = result.worst.front().distance;
    return result;
}

/// How far the embedding takes each vertex from where the anatomy has it: 0 for one inside its element.
Coverage coverage(const Template& body_template, double limit)
{
    Coverage result;
    const Points embedded = apply_embedding(body_template.embedding, body_template.rest.volume_vertices,
                                            body_template.rest.interior_vertices);
    std::map<std::string, double> worst;
    for (const AnatomyPart& part : body_template.anatomy_parts)
        for (int v = part.vertex_begin; v < part.vertex_end; ++v) {
            if (body_template.embedding.elements[v] < 0) {
                ++result.num_skinned;
                continue;
            }
            ++result.num_volumetric;
            const double distance = (embedded.row(v) - body_template.anatomy_vertices.row(v)).norm();
            ++(distance <= rounding ? result.num_inside : distance <= limit ? result.num_near : result.num_far);
            if (!(distance <= limit)) worst[part.name] = std::max(worst[part.name], distance);
        }
    result.worst = sorted_parts(worst);
    return result;
}

WeightCheck check_weights(const Template& body_template)
{
    WeightCheck result;
    const int num_joints = body_template.skeleton.num_joints();
    std::vector<char> used(num_joints, 0);
    bool first = true;
    for (const SkinningWeights* weights :
         {&body_template.skin_weights, &body_template.interior_weights, &body_template.anatomy_weights}) {
        if (weights->size() == 0) continue;
        const double low = weights->weights.minCoeff(), high = weights->weights.maxCoeff();
        result.min_weight = first ? low : std::min(result.min_weight, low);
        result.max_weight = first ? high : std::max(result.max_weight, high);
        first = false;
        result.worst_row_sum =
            std::max(result.worst_row_sum, (weights->weights.rowwise().sum().array() - 1.0).abs().maxCoeff());
        for (Eigen::Index row = 0; row < weights->size(); ++row)
            for (int k = 0; k < max_influences; ++k)
                if (weights->weights(row, k) > 0.0) used[weights->joints(row, k)] = 1;
    }
    for (int j = 0; j < num_joints; ++j) {
        if (used[j])
            ++result.num_joints_used;
        else
            result.unused_joints.push_back(body_template.skeleton.joint_names[j]);
    }
    return result;
}

std::vector<PartDistance> joints_outside(const Template& body_template)
{
    const TriangleTree tree(body_template.rest.skin_vertices, body_template.skin_triangles);
    std::vector<PartDistance> outside;
    for (int j = 0; j < body_template.skeleton.num_joints(); ++j) {
        const double distance = tree.signed_distance(body_template.rest.joint_positions.row(j).transpose());
        if (distance > rounding) outside.push_back({body_template.skeleton.joint_names[j], distance});
    }
    return outside;
}

}  // namespace

TemplateCheck check_template(const Template& original, const TemplateGates& gates)
{
    const Template body_template = as_stored(original);
    TemplateCheck check;
    check.gates = gates;
    check.skin_vertices = static_cast<int>(body_template.rest.skin_vertices.rows());
    check.skin_triangles = static_cast<int>(body_template.skin_triangles.rows());
    check.wrap_vertices = body_template.num_wrap_vertices();
    check.wrap_triangles = static_cast<int>(body_template.wrap_triangles.rows());
    check.prisms = body_template.num_prisms();
    check.tetrahedra = static_cast<int>(body_template.tetrahedra.rows());
    check.interior_vertices = static_cast<int>(body_template.rest.interior_vertices.rows());
    check.anatomy_vertices = static_cast<int>(body_template.anatomy_vertices.rows());
    for (const AnatomyPart& part : body_template.anatomy_parts)
        ++(part.layer == AnatomyLayer::bone ? check.bones : check.muscles);
    check.landmarks = static_cast<int>(body_template.landmarks.size());

    check_jacobians(body_template, check);
    check_surfaces(body_template, check);
    check.bones_inside = containment(body_template, AnatomyLayer::bone, 0);
    check.muscles_inside = containment(body_template, AnatomyLayer::muscle, 1);
    check.coverage = coverage(body_template, gates.embedding_limit);
    check.weights = check_weights(body_template);
    check.joints_outside = joints_outside(body_template);
    check.stature =
        body_template.rest.skin_vertices.col(1).maxCoeff() - body_template.rest.skin_vertices.col(1).minCoeff();
    check.skin_volume = enclosed_volume(body_template.rest.skin_vertices, body_template.skin_triangles);
    check.segments = segment_measures(body_template, body_template.rest, body_template.anatomy_vertices);
    check.worst_asymmetry = worst_asymmetry(check.segments, check.worst_asymmetry_segment);
    return check;
}

}  // namespace ndg
