// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/make_template.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/split_edges.h"
#include "ndg/template_build/landmarks.h"
#include "ndg/template_build/region_cut.h"
#include "ndg/template_build/skin_check.h"
#include "ndg/template_build/symmetric_remesh.h"
#include "ndg/wraps/bone_interior.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// The source with a skin that can be used; what was done to its unit is done to everything.
TemplateSource checked_source(TemplateSource source)
{
    const double given_stature = stature(source.surface.vertices);
    const Eigen::RowVector3d given_root = source.surface.joint_positions.row(0);
    source.surface = checked_skin(source.surface, to_name(source.kind));
    const double scale = stature(source.surface.vertices) / given_stature;
    const Eigen::RowVector3d shift = source.surface.joint_positions.row(0) - scale * given_root;
    if (std::abs(scale - 1.0) < 1e-9 && shift.isZero()) return source;
    source.joint_positions = (scale * source.joint_positions).rowwise() + shift;
    for (AnatomyMesh& mesh : source.anatomy) mesh.vertices = (scale * mesh.vertices).rowwise() + shift;
    return source;
}

constexpr double longest_over_depth = 1.5;  ///< edges of muscles over their distance to the skin

/// Only vertices are embedded: a triangle longer than a fold is wide would cut across it and out of the skin, the
/// sooner the nearer it is to the skin.
void split_muscles(const TriangleTree& skin, const TemplateOptions& options, std::vector<AnatomyMesh>& anatomy)
{
    const double longest = options.muscle_edge, shallow = options.shallow_muscle_edge;
    const auto splits = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        const double length = (a - b).norm();
        if (length <= shallow) return false;
        return length > longest || length > longest_over_depth * skin.closest(0.5 * (a + b)).distance;
    };
    Eigen::Index before = 0, after = 0;
    for (AnatomyMesh& mesh : anatomy) {
        if (mesh.layer != AnatomyLayer::muscle) continue;
        before += mesh.vertices.rows();
        RowMatrix vertices = mesh.vertices;
        split_edges(vertices, mesh.triangles, splits);
        mesh.vertices = vertices;
        after += mesh.vertices.rows();
    }
    log_info("muscles: {} vertices, {} before edges over {:.0f} mm were split, near the skin over {:.0f} mm", after,
             before, 1e3 * longest, 1e3 * shallow);
}

/// Skin vertices as barycentric points on the source surface, and what they inherit from there. Returns the dense
/// weights, N_s x J.
RowMatrix attach_to_source(const TemplateSource& source, const TriangleTree& tree,
                           const Eigen::Ref<const Points>& vertices, Template& result)
{
    const Eigen::Index count = vertices.rows();
    result.source_vertices.resize(count, 3);
    result.source_barycentric.resize(count, 3);
    result.rest.skin_vertices.resize(count, 3);
    RowMatrix dense_weights = RowMatrix::Zero(count, source.weights.cols());
    for (Eigen::Index v = 0; v < count; ++v) {
        const ClosestPoint closest = tree.closest(vertices.row(v).transpose());
        result.source_vertices.row(v) = source.surface.triangles.row(closest.triangle_idx);
        result.source_barycentric.row(v) = closest.barycentric.transpose();
        result.rest.skin_vertices.row(v) = closest.point.transpose();
        for (int k = 0; k < 3; ++k)
            dense_weights.row(v) += closest.barycentric[k] * source.weights.row(result.source_vertices(v, k));
    }
    result.skin_weights = sparsify_weights(dense_weights);
    result.source_joint_offsets = source.joint_positions - source.surface.joint_positions;
    return dense_weights;
}

/// Numbers the vertices of the volumetric triangles in skin order.
void select_wrap(Template& result)
{
    std::vector<int> wrap_of_skin(result.rest.skin_vertices.rows(), -1);
    Eigen::Index num_triangles = 0;
    for (Eigen::Index t = 0; t < result.skin_triangles.rows(); ++t) {
        if (result.skin_regions[t] != 0) continue;
        ++num_triangles;
        for (int k = 0; k < 3; ++k) wrap_of_skin[result.skin_triangles(t, k)] = 0;
    }
    for (std::size_t v = 0; v < wrap_of_skin.size(); ++v) {
        if (wrap_of_skin[v] < 0) continue;
        wrap_of_skin[v] = static_cast<int>(result.wrap_to_skin.size());
        result.wrap_to_skin.push_back(static_cast<int>(v));
    }
    result.wrap_triangles.resize(num_triangles, 3);
    Eigen::Index row = 0;
    for (Eigen::Index t = 0; t < result.skin_triangles.rows(); ++t) {
        if (result.skin_regions[t] != 0) continue;
        for (int k = 0; k < 3; ++k) result.wrap_triangles(row, k) = wrap_of_skin[result.skin_triangles(t, k)];
        ++row;
    }
}

void add_landmarks(const TemplateSource& source, Template& result)
{
    const TriangleTree tree(result.rest.skin_vertices, result.skin_triangles);
    for (const NamedPoint& point :
         skin_landmarks(source.surface.vertices, source.weights, source.surface.joint_positions)) {
        const ClosestPoint closest = tree.closest(point.position);
        result.landmarks.push_back({point.name, closest.triangle_idx, closest.barycentric});
    }
}

void add_wraps(const std::vector<AnatomyMesh>& anatomy, const RowMatrix& dense_weights,
               const AnatomyWrapOptions& options, Template& result)
{
    const int num_wrap = result.num_wrap_vertices();
    WrapSkin skin;
    skin.triangles = result.wrap_triangles;
    skin.joint_positions = result.rest.joint_positions;
    skin.vertices.resize(num_wrap, 3);
    skin.weights.resize(num_wrap, dense_weights.cols());
    for (int w = 0; w < num_wrap; ++w) {
        const int s = result.wrap_to_skin[w];
        skin.vertices.row(w) = result.rest.skin_vertices.row(s);
        skin.weights.row(w) = dense_weights.row(s);
    }
    const Wraps wraps = anatomy_wraps(skin, anatomy, options);
    log_info("wraps: smallest scaled Jacobian {:.3f}", wraps.min_scaled_jacobian);
    result.prisms = layer_prisms(result.wrap_triangles, num_wrap);
    result.rest.volume_vertices.resize(3 * num_wrap, 3);
    result.rest.volume_vertices << wraps.bone, wraps.muscle, skin.vertices;

    const BoneInterior interior = fill_bone_wrap(wraps.bone, result.wrap_triangles, skin.weights);
    result.tetrahedra = interior.tetrahedra;
    result.rest.interior_vertices = interior.vertices;
    result.interior_weights = sparsify_weights(interior.weights);
    log_info("bone interior: {} tetrahedra, {} interior vertices", result.tetrahedra.rows(), interior.vertices.rows());
}

void gather_anatomy(const std::vector<AnatomyMesh>& anatomy, Template& result)
{
    TriangleMesh joined = join_meshes(anatomy);
    result.anatomy_vertices = std::move(joined.vertices);
    result.anatomy_triangles = std::move(joined.triangles);
    int vertex = 0, triangle = 0;
    for (const AnatomyMesh& mesh : anatomy) {
        const int vertex_end = vertex + static_cast<int>(mesh.vertices.rows());
        const int triangle_end = triangle + static_cast<int>(mesh.triangles.rows());
        result.anatomy_parts.push_back(
            {mesh.name, mesh.layer, vertex, vertex_end, triangle, triangle_end, mesh.fma_id, mesh.side});
        vertex = vertex_end;
        triangle = triangle_end;
    }
}

/// Weights of anatomy as the skin next to it has them; bones with a joint of their own follow that alone.
RowMatrix nearby_weights(const TemplateSource& source, const TriangleTree& tree,
                         const std::vector<AnatomyMesh>& anatomy, const Template& body_template)
{
    RowMatrix weights = RowMatrix::Zero(body_template.anatomy_vertices.rows(), source.weights.cols());
    for (std::size_t p = 0; p < anatomy.size(); ++p) {
        const AnatomyPart& part = body_template.anatomy_parts[p];
        const int joint = anatomy[p].joint.empty() ? -1 : body_template.skeleton.joint(anatomy[p].joint);
#pragma omp parallel for schedule(static)
        for (int i = part.vertex_begin; i < part.vertex_end; ++i) {
            if (joint >= 0) {
                weights(i, joint) = 1.0;
                continue;
            }
            const ClosestPoint closest = tree.closest(body_template.anatomy_vertices.row(i).transpose());
            for (int k = 0; k < 3; ++k)
                weights.row(i) +=
                    closest.barycentric[k] * source.weights.row(source.surface.triangles(closest.triangle_idx, k));
        }
    }
    return weights;
}

/// Embeds what lies in the volume or beside it, skins what lies beyond the cuts; vertices within `move_limit` of the
/// volume are moved into it.
void embed_anatomy(const TemplateSource& source, const TriangleTree& tree, const std::vector<AnatomyMesh>& anatomy,
                   double move_limit, Template& result)
{
    gather_anatomy(anatomy, result);
    Embedding& embedding = result.embedding;
    embedding = embed_points(result.anatomy_vertices, result.rest.volume_vertices, result.prisms,
                             result.rest.interior_vertices, result.tetrahedra, result.num_wrap_vertices());
    const RowMatrix nearby = nearby_weights(source, tree, anatomy, result);
    const Eigen::VectorXd field = region_field(result.anatomy_vertices, nearby, source.surface.joint_positions);
    int moved = 0, far = 0;
    double farthest = 0.0;
    for (std::size_t i = 0; i < embedding.elements.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (embedding.distances[i] <= 0.0) continue;
        if (field[row] > 0.0) {
            embedding.elements[i] = -1;
            embedding.distances[i] = 0.0;
            embedding.vertices.row(row).setZero();
            embedding.weights.row(row).setZero();
        } else if (embedding.distances[i] <= move_limit) {
            ++moved;
            embedding.distances[i] = 0.0;
        } else {
            ++far;
            farthest = std::max(farthest, embedding.distances[i]);
        }
    }
    const Points embedded = apply_embedding(embedding, result.rest.volume_vertices, result.rest.interior_vertices);
    result.anatomy_weights =
        embedded_weights(embedding, result.volume_weights(), result.interior_weights, result.skeleton.num_joints());
    const SkinningWeights skinned = sparsify_weights(nearby);
    for (std::size_t i = 0; i < embedding.elements.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (embedding.elements[i] < 0) {
            result.anatomy_weights.joints.row(row) = skinned.joints.row(row);
            result.anatomy_weights.weights.row(row) = skinned.weights.row(row);
        } else if (embedding.distances[i] <= 0.0) {
            result.anatomy_vertices.row(row) = embedded.row(row);
        }
    }
    log_info(
        "anatomy: {} vertices embedded, {} of them moved into the volume by at most {:.1f} mm, {} skinned beyond "
        "the cuts",
        embedding.elements.size() - std::count(embedding.elements.begin(), embedding.elements.end(), -1), moved,
        1e3 * move_limit, std::count(embedding.elements.begin(), embedding.elements.end(), -1));
    if (far > 0)
        log_warning("anatomy: {} vertices lie outside the volume, the farthest by {:.1f} mm", far, 1e3 * farthest);
}

}  // namespace

void describe(OptionList& list, TemplateOptions& options)
{
    list.add("prisms", options.prisms, "wanted number of prisms, reached within a few percent", 1000, 500000);
    list.add("keep-ratio", options.keep_ratio, "share of triangles kept on head, hands and toes", 0.01, 1);
    list.add("move-limit", options.move_limit, "m", 0, 0.02).no_flag();
    list.add("muscle-edge", options.muscle_edge, "longest edge of muscles, m", 0.002, 1);
    list.add(
        "shallow-muscle-edge", options.shallow_muscle_edge,
        "edges of muscles longer than this are split too where they are over 1.5 times as long as deep in the skin, m",
        0.002, 1);
    describe(list, options.cover);
    describe(list, options.wraps);
}

Template make_template(const TemplateSource& given, const TemplateOptions& options)
{
    check_options(options);
    const TemplateSource source = checked_source(given);
    const ParametricSurface& surface = source.surface;
    Template result;
    result.skeleton = standard_skeleton();
    result.rest.name = "template";
    result.source_name = to_name(source.kind);
    result.rest.joint_positions = source.joint_positions;

    const SymmetricRemesher remesher(surface.vertices, surface.triangles, source.weights, surface.joint_positions);
    const RemeshedSkin skin = remesher.remesh(remesher.edge_length_for_prisms(options.prisms), options.keep_ratio);
    result.skin_triangles = skin.triangles;
    result.skin_region_names = skin_region_names;
    result.skin_regions = skin.regions;
    const TriangleTree source_tree(surface.vertices, surface.triangles);
    const RowMatrix dense_weights = attach_to_source(source, source_tree, skin.vertices, result);
    select_wrap(result);
    add_landmarks(source, result);
    log_info("skin: {} vertices, {} triangles, of these volumetric: {} and {}", result.rest.skin_vertices.rows(),
             result.skin_triangles.rows(), result.num_wrap_vertices(), result.wrap_triangles.rows());

    std::vector<AnatomyMesh> anatomy = source.anatomy;
    split_muscles(TriangleTree(result.rest.skin_vertices, result.skin_triangles), options, anatomy);
    const CoverReport cover = cover_with_skin(result.rest.skin_vertices, result.skin_triangles, anatomy, options.cover);
    log_info(
        "cover: least depth of bones {:.1f} mm ({}), of muscles {:.1f} mm ({}); {} vertices moved, at most {:.1f} mm",
        1e3 * cover.min_bone, cover.worst_bone, 1e3 * cover.min_muscle, cover.worst_muscle, cover.moved_vertices,
        1e3 * cover.max_displacement);
    add_wraps(anatomy, dense_weights, options.wraps, result);
    embed_anatomy(source, source_tree, anatomy, options.move_limit, result);
    return result;
}

}  // namespace ndg
