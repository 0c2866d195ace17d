// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/simulation/simulator.h"

#include <string>

namespace ndg {

/// To be raised whenever samples of the same inputs and options come out otherwise: then no dataset is resumed that
/// another method began. tests/simulation/test_simulation_key.cpp notices.
inline constexpr int simulation_method_version = 4;

/// What all finished samples of a dataset depend on: method version, options, and the files that hold template, bodies,
/// poses and splits.
std::string simulation_key(const SimulationOptions& options, const Provenance& provenance);

}  // namespace ndg
