// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/source.h"

#include "ndg/anatomical/registration.h"
#include "ndg/body/skeleton.h"

namespace ndg {

AnatomySource anatomy_source(const MakeHuman& body, const std::string& bodyparts3d_folder,
                             const MakeHumanParameters& person, const AnatomySourceOptions& options)
{
    person.check();
    AnatomySource result;
    TemplateSource& source = result.source;
    source.kind = SourceKind::anatomy;
    source.licence = std::string(makehuman_licence) + " " + bodyparts3d_licence;
    source.surface = body.evaluate(person);
    source.weights = body.weights();
    source.anatomy = read_bodyparts3d(bodyparts3d_folder, options.parts);

    AnatomyTarget target;
    target.vertices = source.surface.vertices;
    target.triangles = source.surface.triangles;
    target.weights = source.weights;
    target.joints = source.surface.joint_positions;
    target.female = person.sex < 0.5;
    source.joint_positions = register_anatomy(source.anatomy, target);
    if (options.fit_to_skin) {
        result.skin_fit = fit_to_skin(source.anatomy, source.joint_positions, target);
        source.joint_positions = symmetric_joints(source.joint_positions);
    }
    const Skeleton& skeleton = standard_skeleton();
    for (const std::string& name : bone_joint_names()) {
        const int j = skeleton.joint(name);
        result.joints.push_back({name, (source.joint_positions.row(j) - target.joints.row(j)).norm()});
    }
    return result;
}

}  // namespace ndg
