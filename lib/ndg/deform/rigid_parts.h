// SPDX-License-Identifier: Apache-2.0
// Bones and muscles without a volume between them, as free atlases in browsers animate them (a row of Table 3).
#pragma once

#include "ndg/deform/deformer.h"

#include <vector>

namespace ndg {

/// Every bone moves as a rigid body with one joint, the one that carries most of it; every muscle is skinned by itself,
/// linearly, with its own weights (Template::anatomy_weights), and so is the skin. Nothing keeps parts apart or inside
/// of the skin. The volume, which is only there for what asks for one, is that of linear blend skinning.
class RigidParts : public Deformer {
public:
    explicit RigidParts(const Template& body_template);

    Points deform(const PosedBody& posed) override { return posed.skinned_volume(); }
    Points anatomy(const PosedBody& posed, const Eigen::Ref<const Points>& anatomy_rest,
                   const Eigen::Ref<const Points>& vertices) override;

private:
    SkinningWeights weights_;  ///< N_a: of bones their joint alone
};

/// "rigid-parts".
void register_rigid_parts(MethodTable& table);

}  // namespace ndg
