// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/driven_body.h"

#include "ndg/core/error.h"

namespace ndg {

SoftTissueBody::SoftTissueBody(const SoftBody& tissue, SoftBodyPoser poser, const TissueOptions& options,
                               double density)
    : poser_(std::move(poser))
{
    tissue.check();
    TissueTerm made = tissue_term(tissue, options, tissue.num_vertices());
    maps_ = made.maps;
    elastic_ = std::make_unique<ElasticBody>(tissue.num_vertices(), tissue.num_held);
    elastic_->add(std::move(made.term));
    elastic_->set_rest(tissue.rest);
    rest_ = tissue.rest;
    skin_ = tissue.skin_triangles;
    masses_ = lumped_masses(tissue.rest, tissue.tetrahedra, density);
    skeleton_ = poser_.skeleton;
    joint_positions_ = poser_.joint_positions;
}

DrivenPose SoftTissueBody::pose(const Pose& pose) const
{
    DrivenPose driven;
    driven.world_from_unposed = poser_.world_from_unposed(pose);
    driven.held = apply_maps(driven.world_from_unposed, rest_).topRows(num_held());
    return driven;
}

void SoftTissueBody::set_pose(const DrivenPose& pose)
{
    if (maps_ != nullptr) maps_->set_world_from_unposed(pose.world_from_unposed);
}

Points SoftTissueBody::equilibrium(const Pose& pose)
{
    return apply_maps(poser_.world_from_unposed(pose), rest_);
}

}  // namespace ndg
