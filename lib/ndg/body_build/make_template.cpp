// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/make_template.h"

#include "ndg/body_build/bone_interior.h"
#include "ndg/body_build/bone_shafts.h"
#include "ndg/body_build/inner_surface.h"
#include "ndg/body_build/region_cut.h"
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/remesh.h"
#include "ndg/geometry/triangle_mesh.h"

#include <cmath>

namespace ndg {

namespace {

constexpr double remesh_margin = 0.025;  ///< m beyond the cuts

/// Skin vertices as barycentric points on the source surface, and what they inherit from there.
void attach_to_source(const ParametricSurface& surface, const Eigen::Ref<const RowMatrix>& weights,
                      const Eigen::Ref<const Points>& vertices, Template& result, RowMatrix& dense_weights)
{
    const TriangleTree tree(surface.vertices, surface.triangles);
    const Eigen::Index count = vertices.rows();
    result.source_vertices.resize(count, 3);
    result.source_barycentric.resize(count, 3);
    result.rest.skin_vertices.resize(count, 3);
    result.source_joint_offsets = Points::Zero(surface.joint_positions.rows(), 3);
    result.source_name = "anatomy";
    dense_weights.setZero(count, weights.cols());
    for (Eigen::Index v = 0; v < count; ++v) {
        const ClosestPoint closest = tree.closest(vertices.row(v).transpose());
        result.source_vertices.row(v) = surface.triangles.row(closest.triangle_idx);
        result.source_barycentric.row(v) = closest.barycentric.transpose();
        result.rest.skin_vertices.row(v) = closest.point.transpose();
        for (int k = 0; k < 3; ++k)
            dense_weights.row(v) += closest.barycentric[k] * weights.row(result.source_vertices(v, k));
    }
}

/// Numbers the vertices of the volumetric triangles (label 1) in skin order.
void select_wrap(const std::vector<int>& labels, Template& result)
{
    std::vector<int> wrap_of_skin(result.rest.skin_vertices.rows(), -1);
    for (std::size_t t = 0; t < labels.size(); ++t)
        if (labels[t] == 1)
            for (int k = 0; k < 3; ++k) wrap_of_skin[result.skin_triangles(static_cast<Eigen::Index>(t), k)] = 0;
    for (std::size_t v = 0; v < wrap_of_skin.size(); ++v) {
        if (wrap_of_skin[v] < 0) continue;
        wrap_of_skin[v] = static_cast<int>(result.wrap_to_skin.size());
        result.wrap_to_skin.push_back(static_cast<int>(v));
    }
    result.wrap_triangles.resize(std::count(labels.begin(), labels.end(), 1), 3);
    Eigen::Index row = 0;
    for (std::size_t t = 0; t < labels.size(); ++t) {
        if (labels[t] != 1) continue;
        for (int k = 0; k < 3; ++k)
            result.wrap_triangles(row, k) = wrap_of_skin[result.skin_triangles(static_cast<Eigen::Index>(t), k)];
        ++row;
    }
}

}  // namespace

void TemplateOptions::check() const
{
    require_input(target_edge_length >= 0.004 && target_edge_length <= 0.08,
                  "target_edge_length is {} m, allowed is 0.004 to 0.08", target_edge_length);
    require_input(keep_ratio > 0.0 && keep_ratio <= 1.0, "keep_ratio is {}, allowed is 0 to 1", keep_ratio);
    require_input(fat_share >= 0.1 && fat_share <= 0.8, "fat_share is {}, allowed is 0.1 to 0.8", fat_share);
    require_input(min_scaled_jacobian > 0.0 && min_scaled_jacobian < 0.5,
                  "min_scaled_jacobian is {}, allowed is 0 to 0.5", min_scaled_jacobian);
}

Template make_template(const ParametricSurface& surface, const Eigen::Ref<const RowMatrix>& weights,
                       const TemplateOptions& options)
{
    options.check();
    const std::string defect = closed_surface_defect(surface.vertices, surface.triangles);
    require_input(defect.empty(), "the skin cannot be used: {}", defect);

    Template result;
    result.skeleton = standard_skeleton();
    result.rest.name = "template";
    result.rest.joint_positions = surface.joint_positions;

    const Eigen::VectorXd field = region_field(surface.vertices, weights, surface.joint_positions);
    // Remeshed a little beyond the cuts, so that the volumetric region holds none of the triangles that join the two
    // resolutions.
    const Eigen::VectorXd remesh_field = field.array() - remesh_margin;
    const CutSurface cut =
        cut_along_zero(surface.vertices, surface.triangles, remesh_field, 0.1 * options.target_edge_length);
    const RemeshResult remeshed = remesh_regions({cut.vertices, cut.triangles}, cut.triangle_labels,
                                                 options.target_edge_length, options.keep_ratio);
    result.skin_triangles = remeshed.mesh.triangles;
    RowMatrix dense_weights;
    attach_to_source(surface, weights, remeshed.mesh.vertices, result, dense_weights);
    result.skin_weights = sparsify_weights(dense_weights);
    Eigen::VectorXd skin_field(result.source_vertices.rows());
    for (Eigen::Index v = 0; v < skin_field.size(); ++v) {
        skin_field[v] = 0.0;
        for (int k = 0; k < 3; ++k)
            skin_field[v] += result.source_barycentric(v, k) * field[result.source_vertices(v, k)];
    }
    select_wrap(volumetric_labels(result.skin_triangles, skin_field), result);
    const int num_wrap = result.num_wrap_vertices();
    result.prisms = layer_prisms(result.wrap_triangles, num_wrap);
    log_info("skin: {} vertices, {} triangles, of these volumetric: {} and {}", result.rest.skin_vertices.rows(),
             result.skin_triangles.rows(), num_wrap, result.wrap_triangles.rows());

    WrapSkin skin;
    skin.triangles = result.wrap_triangles;
    skin.joint_positions = surface.joint_positions;
    skin.vertices.resize(num_wrap, 3);
    skin.weights.resize(num_wrap, weights.cols());
    for (int w = 0; w < num_wrap; ++w) {
        skin.vertices.row(w) = result.rest.skin_vertices.row(result.wrap_to_skin[w]);
        skin.weights.row(w) = dense_weights.row(result.wrap_to_skin[w]);
    }
    const Points projection = skeleton_projection(skin);
    const Eigen::VectorXd share = soft_tissue_share(skin);
    const Points intended = skin.vertices + share.asDiagonal() * (projection - skin.vertices);
    const Wraps wraps = valid_wraps(skin, intended, Eigen::VectorXd::Constant(num_wrap, options.fat_share),
                                    options.min_scaled_jacobian, "template");
    log_info("wraps: {} vertices adjusted, smallest scaled Jacobian {:.3f}", wraps.adjusted_vertices,
             wraps.min_scaled_jacobian);
    result.rest.volume_vertices.resize(3 * num_wrap, 3);
    result.rest.volume_vertices << wraps.bone, wraps.muscle, skin.vertices;

    const BoneInterior interior = fill_bone_wrap(wraps.bone, result.wrap_triangles, skin.weights);
    result.tetrahedra = interior.tetrahedra;
    result.rest.interior_vertices = interior.vertices;
    result.interior_weights = sparsify_weights(interior.weights);
    log_info("bone interior: {} tetrahedra, {} interior vertices", result.tetrahedra.rows(), interior.vertices.rows());

    Anatomy anatomy = make_bone_shafts(surface.joint_positions, close_bone_wrap(wraps.bone, result.wrap_triangles));
    result.anatomy_vertices = anatomy.vertices;
    result.anatomy_triangles = anatomy.triangles;
    result.anatomy_parts = anatomy.parts;
    result.embedding = embed_points(anatomy.vertices, result.rest.volume_vertices, result.prisms,
                                    result.rest.interior_vertices, result.tetrahedra, num_wrap);
    return result;
}

}  // namespace ndg
