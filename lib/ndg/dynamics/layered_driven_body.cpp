// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/layered_driven_body.h"

#include "ndg/core/error.h"
#include "ndg/elastic/elements.h"
#include "ndg/elastic/varied_layered_body.h"

namespace ndg {

LayeredDrivenBody::LayeredDrivenBody(const Template& body_template, const Body& body, const SimulationOptions& options,
                                     double density, const Eigen::VectorXd& stiffness_scales)
    : body_(body),
      options_(options),
      poser_(body_template, options.posing),
      weights_(body_template.volume_weights()),
      stiffness_scales_(stiffness_scales)
{
    elastic_ = std::make_unique<ElasticBody>(
        stiffness_scales.size() == 0 ? layered_body(body_template, options.material)
                                     : varied_layered_body(body_template, options.material, stiffness_scales));
    elastic_->set_rest(body.volume_vertices);
    rest_ = body.volume_vertices;
    skin_ = body_template.wrap_triangles.array() + 2 * body_template.num_wrap_vertices();
    masses_ = lumped_prism_masses(rest_, body_template.prisms, density);
    skeleton_ = body_template.skeleton;
    joint_positions_ = body.joint_positions;
}

DrivenPose LayeredDrivenBody::pose(const Pose& pose) const
{
    const PosedBody posed = poser_.pose(body_, pose);
    DrivenPose driven;
    driven.held = posed.bone_wrap();
    driven.world_from_unposed.assign(static_cast<std::size_t>(rest_.rows()), AffineMap::Zero());
    for (Eigen::Index v = 0; v < rest_.rows(); ++v) {
        for (int k = 0; k < max_influences; ++k) {
            const auto joint = static_cast<std::size_t>(weights_.joints(v, k));
            driven.world_from_unposed[static_cast<std::size_t>(v)] +=
                weights_.weights(v, k) * posed.world_from_rest()[joint].matrix().topRows<3>();
        }
    }
    return driven;
}

Points LayeredDrivenBody::equilibrium(const Pose& pose)
{
    Simulator simulator(poser_, options_);
    simulator.set_body(body_);
    SimulationResult result = simulator.simulate(pose);
    if (result.newton.converged() && stiffness_scales_.size() > 0) {
        // elastic_ may know an integrator's terms by now.
        ElasticBody still = varied_layered_body(poser_.body_template(), options_.material, stiffness_scales_);
        still.set_rest(rest_);
        const Objective objective(still);
        result.newton = NewtonSolver(objective).minimise(result.vertices, options_.newton);
    }
    require(result.newton.converged(), "the flesh finds no equilibrium in the first pose: Newton's method {}",
            describe(result.newton.stop));
    return result.vertices;
}

Eigen::VectorXd lumped_prism_masses(const Eigen::Ref<const Points>& rest, const Eigen::Ref<const Prisms>& prisms,
                                    double density)
{
    Eigen::VectorXd masses = Eigen::VectorXd::Zero(rest.rows());
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        const double mass = density * prism_volume(corner_positions<6>(rest, prisms.row(p).data())) / 6;
        for (int a = 0; a < 6; ++a) masses[prisms(p, a)] += mass;
    }
    return masses;
}

}  // namespace ndg
