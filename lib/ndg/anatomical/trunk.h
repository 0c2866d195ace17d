// SPDX-License-Identifier: Apache-2.0
// Trunk, neck and head of one skeleton brought into another person's skin by a smooth map.
#pragma once

#include "ndg/anatomical/joints.h"
#include "ndg/body_source/template_source.h"

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

/// x -> (scale_x(y) x, height(y), scale_z(y) z + offset_z(y)), with coefficients smooth in the height y of the source:
/// hips, sternal ends of the clavicles and atlas come to the target's heights; spine and breastbone (in the midline,
/// where a breast does not count), and the sides of the rib cage come to lie under the target's skin. The skull keeps
/// to its own such map, fitted to the head above the eyes, to the eyes and to the chin; the neck blends both. Hips come
/// to lie between where the rest of the skeleton puts them and the target's joints.
class TrunkMap {
public:
    TrunkMap(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target);

    Eigen::Vector3d trunk(const Eigen::Vector3d& source) const;
    Eigen::Vector3d head(const Eigen::Vector3d& source) const;

private:
    void fit_head(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target);
    void fit_heights(const BonePoints& points, const AnatomyTarget& target);
    void fit_sections(const std::vector<AnatomyMesh>& parts, const BonePoints& points, const AnatomyTarget& target);
    void add_pelvis(const BonePoints& points, const AnatomyTarget& target, double stature_scale, double crest);
    Eigen::Vector3d below_head(const Eigen::Vector3d& source) const;
    double height(double source_height) const;

    std::vector<double> height_knots_, height_values_;                    // source height -> target height
    std::vector<double> section_heights_, scale_x_, scale_z_, offset_z_;  // by source height
    Eigen::Vector3d head_scale_ = Eigen::Vector3d::Ones(), head_offset_ = Eigen::Vector3d::Zero();
    std::vector<double> head_heights_, head_values_;  // source height -> target height of the skull
    double neck_begin_ = 0, neck_end_ = 0;            // source heights between which trunk and head blend
};

}  // namespace ndg
