// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/projective_skinning.h"

#include "ndg/deform/gradient_skinning.h"
#include "ndg/deform/nearest_rotations.h"
#include "ndg/deform/rest_cache.h"

#include <limits>

namespace ndg {

namespace {

class ProjectiveSkinning : public Deformer {
public:
    ProjectiveSkinning(const Template& body_template, const ProjectiveOptions& options)
        : rest_(body_template), options_(options)
    {
    }
    Points deform(const PosedBody& posed) override
    {
        const RestOperators& rest = rest_.operators(posed.body());
        return projective_skinning(posed, rest, rest_.poisson(posed.body()), options_);
    }

private:
    RestCache rest_;
    ProjectiveOptions options_;
};

}  // namespace

void describe(OptionList& list, ProjectiveOptions& options)
{
    list.add("projective-iterations", options.iterations, "iterations of Projective Skinning, at most", 0, 100000);
    list.add("projective-decrease", options.least_decrease,
             "share of its energy that an iteration of Projective Skinning must gain for another to follow", 0, 1);
}

Points projective_skinning(const PosedBody& posed, const RestOperators& rest, const PoissonReconstruction& poisson,
                           const ProjectiveOptions& options)
{
    Points vertices = gradient_skinning(posed, poisson);
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < options.iterations; ++i) {
        const Gradients gradients = rest.deformation_gradients(vertices);
        const Gradients rotations = nearest_rotations(gradients);
        double energy = 0;
        for (int p = 0; p < rest.num_prisms(); ++p)
            energy += rest.volume(p) * (gradients.row(p) - rotations.row(p)).squaredNorm();
        if (!(energy < (1 - options.least_decrease) * before)) break;
        before = energy;
        vertices = poisson.reconstruct(rotations, posed.bone_wrap());
    }
    return vertices;
}

void register_projective_skinning(MethodTable& table)
{
    const auto options = std::make_shared<ProjectiveOptions>();
    table.add({"projective-skinning", "Projective Skinning",
               "every prism near a rotation, by local and global steps in turn",
               [options](Tool& tool) { tool.options(*options); },
               [options](const BodyPoser& poser) {
                   return std::make_unique<ProjectiveSkinning>(poser.body_template(), *options);
               }});
}

}  // namespace ndg
