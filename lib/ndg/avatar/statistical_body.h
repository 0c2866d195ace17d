// SPDX-License-Identifier: Apache-2.0
// A statistical body: skins that are linear in shape and pose before linear blend skinning (Romero et al. 2020, 3.1;
// Loper et al. 2015). docs/statistical-body.md says how to bring one's own.
#pragma once

#include "ndg/avatar/joint_weights.h"
#include "ndg/body/skeleton.h"
#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// N skin vertices, K joints, B shape directions, P joints that drive pose directions.
struct StatisticalBody {
    std::string name;
    Points vertices;               ///< N x 3, m: the template, at shape 0
    Triangles triangles;           ///< T x 3, outward
    RowMatrixF shape_directions;   ///< B x 3 N, m: x y z of each vertex for one of each shape parameter
    std::vector<int> pose_joints;  ///< P
    RowMatrixF pose_directions;    ///< 9 P x 3 N, m, for the entries of R - I (pose_directions.h)
    JointWeights joint_regressor;  ///< K x N, rows sum to one; entries may be negative
    JointWeights weights;          ///< N x K
    Skeleton skeleton;
    /// T: 1 for triangles that have soft tissue below them, 0 for head, hands and feet. Empty where nobody said so.
    std::vector<int> soft_triangles;

    /// People whose shapes are known, by name; may be none.
    std::vector<std::string> people;
    RowMatrix people_shapes;  ///< people x B

    int num_vertices() const { return static_cast<int>(vertices.rows()); }
    int num_joints() const { return skeleton.num_joints(); }
    int num_shapes() const { return static_cast<int>(shape_directions.rows()); }

    /// N x 3: template and shape directions. Fewer shape parameters than directions: the others are zero.
    Points rest_vertices(const Eigen::Ref<const Eigen::VectorXd>& shape) const;
    /// K x 3: joints of a rest shape.
    Points joint_positions(const Eigen::Ref<const Points>& rest_vertices) const;
    /// Index into `people`. Throws InputError naming those there are.
    int person(const std::string& person_name) const;
};

/// A statistical body in a pose, m.
struct PosedSkin {
    Points vertices;  ///< N x 3
    Points joints;    ///< K x 3
};
PosedSkin skin_body(const StatisticalBody& body, const Eigen::Ref<const Eigen::VectorXd>& shape, const Pose& pose);

/// What does not fit together in a body, "" where all does: names the field and the value.
std::string statistical_body_defect(const StatisticalBody& body);

/// Format "ndg-statistical-body", version 1 (docs/formats.md).
void write_statistical_body(const std::string& path, const StatisticalBody& body, const Provenance& provenance);
/// Throws InputError naming file, dataset and value for anything inconsistent.
StatisticalBody read_statistical_body(const std::string& path);

}  // namespace ndg
