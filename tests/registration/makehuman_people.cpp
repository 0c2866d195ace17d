// SPDX-License-Identifier: Apache-2.0
#include "registration/makehuman_people.h"

#include "ndg/body/person.h"
#include "ndg/body_source/template_source.h"
#include "ndg/geometry/adaptive_remesh.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/makehuman/files.h"
#include "ndg/people/body_sampling.h"
#include "ndg/template_build/symmetric_remesh.h"

namespace ndg::test {

Template makehuman_skin_template(const MakeHuman& source, const std::string& folder)
{
    MakeHumanParameters man;
    man.sex = male_share(Sex::male);
    const ParametricSurface surface = source.evaluate(man);
    const SymmetricRemesher remesher(surface.vertices, surface.triangles, source.weights(), surface.joint_positions);
    const RemeshedSkin skin = remesher.remesh(remesher.edge_length_for_prisms(15000), 0.25);
    Template result;
    result.skeleton = standard_skeleton();
    result.source_name = to_name(SourceKind::anatomy);
    result.skin_triangles = skin.triangles;
    result.rest.skin_vertices = skin.vertices;
    result.rest.joint_positions = surface.joint_positions;
    result.source_joint_offsets = Points::Zero(num_standard_joints, 3);
    const Eigen::Index count = skin.vertices.rows();
    result.source_vertices.resize(count, 3);
    result.source_barycentric.resize(count, 3);
    RowMatrix weights = RowMatrix::Zero(count, source.weights().cols());
    const TriangleTree tree(surface.vertices, surface.triangles);
    for (Eigen::Index v = 0; v < count; ++v) {
        const ClosestPoint closest = tree.closest(skin.vertices.row(v).transpose());
        result.source_vertices.row(v) = surface.triangles.row(closest.triangle_idx);
        result.source_barycentric.row(v) = closest.barycentric.transpose();
        for (int k = 0; k < 3; ++k) {
            weights.row(v) += closest.barycentric[k] * source.weights().row(result.source_vertices(v, k));
        }
    }
    result.skin_weights = sparsify_weights(weights);
    result.examples = sample_skins(result, folder, 48, 1001, {}).bodies;
    return result;
}

SkinnedSurface makehuman_person(const MakeHuman& source, const std::string& folder,
                                const MakeHumanParameters& parameters,
                                const std::vector<std::pair<std::string, double>>& targets)
{
    ParametricSurface surface = source.evaluate(parameters);
    for (const auto& [name, weight] : targets) {
        const MakeHumanTarget target = read_makehuman_target(folder + "/targets/" + name + ".target.gz", 19158);
        for (std::size_t i = 0; i < target.vertices.size(); ++i) {
            if (target.vertices[i] >= surface.vertices.rows()) continue;
            surface.vertices.row(target.vertices[i]) += 0.1 * weight * target.offsets.row(static_cast<Eigen::Index>(i));
        }
    }
    return {surface.vertices, surface.triangles, sparsify_weights(source.weights()), surface.joint_positions};
}

Points remeshed_and_smoothed(const SkinnedSurface& skin, double edge_length, int smoothing_rounds, Triangles& triangles)
{
    RemeshField field;
    field.edge_length = Eigen::VectorXd::Constant(skin.vertices.rows(), edge_length);
    field.fixed.assign(skin.vertices.rows(), 0);
    LabelledMesh mesh =
        remesh_adaptively({skin.vertices, skin.triangles}, std::vector<int>(skin.triangles.rows(), 1), field);
    Points vertices = std::move(mesh.mesh.vertices);
    triangles = std::move(mesh.mesh.triangles);
    const auto neighbours = vertex_neighbours(triangles, static_cast<int>(vertices.rows()));
    for (int round = 0; round < smoothing_rounds; ++round) {
        const Points old = vertices;
        for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
            Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
            for (const int other : neighbours[v]) mean += old.row(other) / static_cast<double>(neighbours[v].size());
            vertices.row(v) += 0.4 * (mean - old.row(v));
        }
    }
    return vertices;
}

}  // namespace ndg::test
