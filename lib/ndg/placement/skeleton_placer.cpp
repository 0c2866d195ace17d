// SPDX-License-Identifier: Apache-2.0
#include "ndg/placement/skeleton_placer.h"

#include "ndg/body_source/bone_parts.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>

namespace ndg {

bool SkeletonPlacer::has_trunk_bones(const Template& body_template)
{
    return std::any_of(body_template.anatomy_parts.begin(), body_template.anatomy_parts.end(),
                       [](const AnatomyPart& part) { return part.name.find("lumbar vertebra") != std::string::npos; });
}

SkeletonPlacer::SkeletonPlacer(const Template& body_template)
    : template_(&body_template), bones_(ndg::trunk_bones(bone_meshes(body_template, body_template.anatomy_vertices)))
{
    const Skeleton& skeleton = body_template.skeleton;
    on_trunk_ = on_trunk(dense_weights(body_template.skin_weights, skeleton.num_joints()));
    for (const char* name : {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5", "neck_1", "neck_2",
                             "left_clavicle", "right_clavicle", "left_thigh", "right_thigh"})
        trunk_joints_.push_back(skeleton.joint(name));
}

TrunkMap SkeletonPlacer::trunk_map(const Skin& skin, double sex) const
{
    TrunkTarget target;
    target.vertices = skin.skin_vertices;
    target.triangles = template_->skin_triangles;
    target.on_trunk = on_trunk_;
    target.joints = skin.joint_positions;
    target.stature = stature(skin.skin_vertices);
    target.bmi = body_density * enclosed_volume(skin.skin_vertices, template_->skin_triangles) /
                 (target.stature * target.stature);
    target.sex = sex;
    return TrunkMap(bones_, template_->rest.joint_positions, target);
}

Points SkeletonPlacer::joints(const Skin& skin, const TrunkMap& map) const
{
    Points joints = skin.joint_positions;
    for (const int j : trunk_joints_)
        joints.row(j) = map(template_->rest.joint_positions.row(j).transpose()).transpose();
    return joints;
}

}  // namespace ndg
