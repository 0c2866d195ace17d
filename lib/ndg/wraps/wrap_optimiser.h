// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/solver/sparse_cholesky.h"
#include "ndg/wraps/wrap_energy.h"

#include <string>

namespace ndg {

struct WrapTargets {
    double min_scaled_jacobian = 0.085;  ///< bounds that are kept once they are reached
    double min_thickness = 0.0008;       ///< m of either layer
};

/// Moves wraps from valid to valid state down the energy of WrapEnergy; what it accepts is valid by construction.
class WrapOptimiser {
public:
    /// Starts from a thin shell under the skin. Throws Error naming `name` and the place where not even that is valid.
    WrapOptimiser(const WrapSkin& skin, WrapEnergy& energy, const WrapTargets& targets, std::string name);
    /// Starts from valid wraps.
    WrapOptimiser(const WrapSkin& skin, WrapEnergy& energy, const WrapTargets& targets, WrapPair start);

    /// Flows until five iterations lower the energy by less than the share `tolerance`. Returns the number of
    /// iterations.
    int flow(int max_iterations, double tolerance);

    const WrapPair& wraps() const { return wraps_; }

private:
    /// Bounds rise to the targets where the wraps are well above them, and never fall.
    void raise_bounds();

    const WrapSkin& skin_;
    WrapEnergy& energy_;
    WrapTargets targets_;
    WrapPair wraps_;
    SparseCholesky solver_{SparseCholesky::Method::supernodal};
    bool analysed_ = false;
};

}  // namespace ndg
