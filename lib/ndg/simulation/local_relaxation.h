// SPDX-License-Identifier: Apache-2.0
// Nonlinear elimination (Lanzkron, Rose and Wilkes 1996; Cai and Keyes 2002). Where flesh folds, a few creases of the
// skin soon hold nearly all of the forces out of balance and shorten the steps of the whole body. They are brought to
// equilibrium by themselves, with the rest held, before every step of the whole.
#pragma once

#include "ndg/simulation/newton.h"

#include <vector>

namespace ndg {

class LocalRelaxation {
public:
    /// Keeps a reference to the whole body's `objective`.
    explicit LocalRelaxation(const Objective& objective);

    /// Moves the vertices of patches around those with most of the force and lowers the energy of each; false, and
    /// nothing has moved, where the forces are spread widely. `gradient`: at `positions`; `filter`: of every step.
    bool relax(Points& positions, const Eigen::VectorXd& gradient, const StepFilter& filter = {});

private:
    /// Connected patches of unknown vertices, each `rings` rings of cells about vertices that hold most of the force;
    /// none where these are many.
    std::vector<std::vector<int>> find_patches(const Eigen::VectorXd& gradient, int rings) const;

    const Objective& objective_;
    std::vector<std::vector<int>> neighbours_;  ///< per unknown vertex: the other unknown ones of its cells
};

}  // namespace ndg
