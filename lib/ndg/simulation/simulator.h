// SPDX-License-Identifier: Apache-2.0
// One body in one pose: warm start, Newton, and load stepping where that fails.
#pragma once

#include "ndg/body/joint_flesh.h"
#include "ndg/deform/poisson.h"
#include "ndg/deform/posed_body.h"
#include "ndg/elastic/layered_body.h"
#include "ndg/geometry/prism.h"
#include "ndg/simulation/contact_solver.h"
#include "ndg/simulation/local_relaxation.h"
#include "ndg/simulation/newton.h"

#include <memory>
#include <string>

namespace ndg {

struct SimulationOptions {
    PosingOptions posing;
    MaterialOptions material;
    ContactOptions contact;
    NewtonOptions newton;
    /// Steps from rest to the pose where the direct solve fails; 0: no such second attempt.
    int load_steps = 8;
};
void describe(OptionList& list, SimulationOptions& options);
/// All but the posing, for those who get bodies posed already.
void describe_solve(OptionList& list, SimulationOptions& options);

struct SimulationResult {
    Points vertices;      ///< N_v x 3
    NewtonResult newton;  ///< of the last solve; iterations summed over all of them
    int load_steps = 0;   ///< 0: the direct solve was enough
    InvertedPrisms inverted_prisms;
    int intersecting_triangles = 0;      ///< of the skin, that others pass through
    std::vector<double> volume_changes;  ///< at flesh_joint_names()
};

/// The pose a share of the way from rest: every joint rotation's angle and the root's displacement scaled by `share`.
Pose scale_pose(const Pose& pose, double share);

/// Workspace for one thread. The result depends on body and pose alone, never on what was simulated before.
class Simulator {
public:
    /// Keeps a reference to `body_template`. Throws InputError for options out of range.
    Simulator(const Template& body_template, const SimulationOptions& options);
    /// With a poser for all, in the place of options.posing: what it knows of the template is not made again.
    Simulator(const BodyPoser& poser, const SimulationOptions& options);
    Simulator(const Simulator&) = delete;
    Simulator& operator=(const Simulator&) = delete;

    /// Rest data of a body; must be called before simulate(). Keeps a reference to `body`.
    void set_body(const Body& body);
    /// Starts from gradient skinning; if Newton's method fails there, goes from rest to the pose in load steps. With
    /// contact goes on from there, where skin crosses skin or is near to it.
    SimulationResult simulate(const Pose& pose);
    /// Gradient skinning, where Newton's method starts; N_v x 3.
    Points start(const Pose& pose) const;

    const Objective& objective() const { return objective_; }

private:
    NewtonResult minimise(Points& vertices, const NewtonOptions& options);
    NewtonResult solve_in_steps(const Pose& pose, Points& vertices);
    /// Counts and volumes of result.vertices.
    void measure(SimulationResult& result) const;

    BodyPoser poser_;
    SimulationOptions options_;
    const Prisms& prisms_;
    JointFlesh joint_flesh_;
    ElasticBody elastic_;
    Objective objective_;
    PoissonReconstruction poisson_;
    NewtonSolver newton_;
    LocalRelaxation relaxation_;
    std::unique_ptr<ContactSolver> contact_;  ///< none without contact
    Eigen::SparseMatrix<double> gradient_operator_;
    const Body* body_ = nullptr;
};

}  // namespace ndg
