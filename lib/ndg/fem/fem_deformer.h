// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/deform/deformer.h"

namespace ndg {

/// "fem": the quasi-static simulation, with its options. One sample at a time; datasets are simulated by
/// simulate_samples.
void register_fem(MethodTable& table);

}  // namespace ndg
