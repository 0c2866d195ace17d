// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/simulation_parameters.h"

namespace ndg {

void add_simulation_parameters(Tool& tool, SimulationOptions& options)
{
    tool.parameter("energy", options.material.energy,
                   "flesh energy; inversion-free guards the volume of every prism too", {"paper", "inversion-free"});
    tool.parameter("young-muscle", options.material.young_muscle_pascal, "Young's modulus of the muscle layer, Pa", 1,
                   1e9);
    tool.parameter("young-fat", options.material.young_fat_pascal, "Young's modulus of the fat layer, Pa", 1, 1e9);
    tool.parameter("poisson-ratio", options.material.poisson_ratio, "Poisson's ratio of both layers", 0.13, 0.4999);
    tool.parameter("flesh-stiffness", options.material.flesh_stiffness, "factor k_f of the flesh energy", 1e-6, 1e6);
    tool.parameter("stretch-stiffness", options.material.stretch_stiffness, "factor k_s of skin stretching, J", 0, 1e6);
    tool.parameter("bend-stiffness", options.material.bend_stiffness, "factor k_b of skin bending, J", 0, 1e6);
    tool.parameter("relative-tolerance", options.newton.relative_tolerance,
                   "converged at this share of forces out of balance", 1e-14, 0.1);
    tool.parameter("absolute-tolerance", options.newton.absolute_tolerance_newton,
                   "or at this norm of the forces out of balance, N", 0, 1);
    tool.parameter("max-iterations", options.newton.max_iterations, "limit of Newton iterations a solve", 1, 10000);
    tool.parameter("load-steps", options.load_steps, "steps from rest where the direct solve fails; 0: none", 0, 1000);
}

}  // namespace ndg
