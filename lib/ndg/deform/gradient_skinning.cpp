// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/gradient_skinning.h"

#include "ndg/deform/rest_cache.h"

namespace ndg {

namespace {

class GradientSkinning : public Deformer {
public:
    explicit GradientSkinning(const Template& body_template) : rest_(body_template) {}
    Points deform(const PosedBody& posed) override { return gradient_skinning(posed, rest_.poisson(posed.body())); }

private:
    RestCache rest_;
};

}  // namespace

Points gradient_skinning(const PosedBody& posed, const PoissonReconstruction& poisson)
{
    return poisson.reconstruct(posed.prism_rotations(), posed.bone_wrap());
}

void register_gradient_skinning(MethodTable& table)
{
    table.add({"gradient-skinning",
               "Gradient Skinning",
               "every prism turned with the bones, then a Poisson solve",
               {},
               [](const BodyPoser& poser) { return std::make_unique<GradientSkinning>(poser.body_template()); }});
}

}  // namespace ndg
