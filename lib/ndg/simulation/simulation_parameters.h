// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/tool.h"
#include "ndg/simulation/simulator.h"

namespace ndg {

/// Every option of a simulation as a parameter of a tool, which keeps a reference to `options`.
void add_simulation_parameters(Tool& tool, SimulationOptions& options);

}  // namespace ndg
