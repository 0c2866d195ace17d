// SPDX-License-Identifier: Apache-2.0
// Which bone a part of the anatomy is, by its name: those of BodyParts3D and of the procedural body.
#pragma once

#include "ndg/body/anatomy_part.h"
#include "ndg/body/skeleton.h"

#include <string>

namespace ndg {

/// How a bone moves.
enum class BoneKind {
    joint,      ///< with a joint of the skeleton
    vertebra,   ///< number: 0 fifth lumbar, ..., 5 twelfth thoracic, ..., 16 first thoracic, ..., 23 atlas
    disk,       ///< number: of the vertebra above it
    rib,        ///< number: 1 to 12
    cartilage,  ///< of the rib of that number
    sternum,
    clavicle,
    scapula,
    radius,
    ulna,
    shank,  ///< tibia and fibula
    patella,
    unknown
};

struct BoneName {
    BoneKind kind = BoneKind::unknown;
    int number = -1;  ///< of a vertebra, disk, rib or cartilage
    int joint = -1;   ///< of kind joint
};

constexpr int num_vertebrae = 24;
/// Number of the n-th (1 to 12) thoracic vertebra among the vertebrae.
constexpr int thoracic_vertebra(int n)
{
    return 17 - n;
}

/// Kind `unknown` for what no rule names, and for everything on a skeleton other than the standard one.
BoneName name_bone(const AnatomyPart& part, const Skeleton& skeleton);

}  // namespace ndg
