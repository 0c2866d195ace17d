// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/dynamics/driven_body.h"
#include "ndg/simulation/simulator.h"

namespace ndg {

/// A layered body of prisms (elastic/layered_body.h) with inertia: muscle, fat and skin move, the bone wrap is that of
/// the pose. Keeps references to template and body.
class LayeredDrivenBody : public DrivenBody {
public:
    /// `stiffness_scales`: of every prism (elastic/varied_layered_body.h); empty: flesh of a kind is alike everywhere.
    LayeredDrivenBody(const Template& body_template, const Body& body, const SimulationOptions& options, double density,
                      const Eigen::VectorXd& stiffness_scales = {});

    DrivenPose pose(const Pose& pose) const override;
    /// Static equilibrium, by Simulator; where flesh is not alike everywhere, from there on by Newton's method. Throws
    /// Error where that finds none.
    Points equilibrium(const Pose& pose) override;

private:
    const Body& body_;
    SimulationOptions options_;
    BodyPoser poser_;
    SkinningWeights weights_;
    Eigen::VectorXd stiffness_scales_;
};

/// Of every vertex a sixth of its prisms', kg.
Eigen::VectorXd lumped_prism_masses(const Eigen::Ref<const Points>& rest, const Eigen::Ref<const Prisms>& prisms,
                                    double density);

}  // namespace ndg
