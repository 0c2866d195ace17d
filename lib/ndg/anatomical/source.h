// SPDX-License-Identifier: Apache-2.0
// Real bones and muscles in a parametric skin: BodyParts3D's anatomy brought into MakeHuman's body.
#pragma once

#include "ndg/anatomical/bodyparts3d.h"
#include "ndg/anatomical/skin_fit.h"
#include "ndg/body_source/template_source.h"
#include "ndg/makehuman/makehuman.h"

#include <string>
#include <vector>

namespace ndg {

struct AnatomySourceOptions {
    BodyParts3DOptions parts;
    bool fit_to_skin = true;  ///< false: only posed and scaled, muscles may stick out of the skin
};

struct AnatomyJoint {
    std::string name;
    double distance = 0.0;  ///< of the bones' centre of rotation from MakeHuman's own joint, m
};

struct AnatomySource {
    TemplateSource source;
    std::vector<AnatomyJoint> joints;
    SkinFitReport skin_fit;
};

/// MakeHuman's body of these parameters with the bones and muscles of BodyParts3D's man inside, posed, scaled and
/// fitted to the skin (anatomy_registration.h, anatomy_skin_fit.h). Every part keeps its name, FMA id, side and layer
/// (bodyparts3d.h says how they are read from the files' names); bones know the joint they follow. Anatomy nearer to
/// the skin than wanted is left to cover_with_skin. Deterministic; about half a minute on two cores. Throws InputError
/// for missing or malformed files.
AnatomySource anatomy_source(const MakeHuman& body, const std::string& bodyparts3d_folder,
                             const MakeHumanParameters& person, const AnatomySourceOptions& options = {});

}  // namespace ndg
