// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/simulation/simulator.h"
#include "support/support.h"

namespace ndg::test {

/// The defaults, for the tube.
inline SimulationOptions bending_simulation()
{
    SimulationOptions options;
    options.posing = bending;
    return options;
}

}  // namespace ndg::test
