// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/simulation_key.h"

namespace ndg {

std::string simulation_key(const SimulationOptions& options, const Provenance& provenance)
{
    return run_key("simulation", simulation_method_version, options_key(options), data_hashes(provenance));
}

}  // namespace ndg
