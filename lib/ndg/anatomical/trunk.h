// SPDX-License-Identifier: Apache-2.0
// Trunk, neck and head of one skeleton brought into another person's skin by a smooth map.
#pragma once

#include "ndg/anatomical/joints.h"
#include "ndg/body_source/template_source.h"
#include "ndg/placement/trunk_map.h"

#include <optional>
#include <vector>

namespace ndg {

/// The skin an anatomy is brought into: surface, N x J weights and joints of the standard skeleton.
struct AnatomyTarget {
    Points vertices;
    Triangles triangles;
    RowMatrix weights;
    Points joints;
    bool female = false;

    Eigen::Vector3d joint(const std::string& name) const;
    /// Sum of the weights of joints whose name starts with one of `prefixes`, N.
    Eigen::VectorXd region_weight(const std::vector<std::string>& prefixes) const;
};

/// The axial skeleton: trunk and neck by TrunkMap, the skull by a map of its own, fitted to the head above the eyes, to
/// the eyes and to the chin; between seventh cervical vertebra and atlas both are blended.
class AxialMap {
public:
    AxialMap(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target);

    Eigen::Vector3d trunk(const Eigen::Vector3d& source) const;
    Eigen::Vector3d head(const Eigen::Vector3d& source) const;

private:
    void fit_head(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target);

    std::optional<TrunkMap> below_head_;
    Eigen::Vector3d head_scale_ = Eigen::Vector3d::Ones(), head_offset_ = Eigen::Vector3d::Zero();
    std::vector<double> head_heights_, head_values_;  // source height -> target height of the skull
    double neck_begin_ = 0, neck_end_ = 0;            // source heights between which trunk and head blend
};

}  // namespace ndg
