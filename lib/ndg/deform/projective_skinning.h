// SPDX-License-Identifier: Apache-2.0
// Projective Skinning (NDG equation 24; Komaritzan and Botsch 2018, 2019): the quasi-static minimum of an energy that
// asks every prism for a rotation.
#pragma once

#include "ndg/core/options.h"
#include "ndg/deform/deformer.h"
#include "ndg/deform/poisson.h"

namespace ndg {

struct ProjectiveOptions {
    int iterations = 30;  ///< at most; NDG 5.2.2 allows as many
    /// An iteration that lowers the energy by no more than this share of it is the last.
    double least_decrease = 0;
};
void describe(OptionList& list, ProjectiveOptions& options);

/// Lowers sum_p V_p min_R |F_p - R|^2, R over the rotations, V_p the rest volumes (as Projective Dynamics weighs
/// strain, Bouaziz et al. 2014; equation 24 prints no weights), the bone wrap given, N_v x 3. Starts from Gradient
/// Skinning; every iteration takes the nearest rotations (local step) and solves for vertices (global step), which
/// never raises the energy. The matrix of the global step is that of the Poisson reconstruction, whose factor `poisson`
/// brings. `rest` and `poisson` must be of the body.
Points projective_skinning(const PosedBody& posed, const RestOperators& rest, const PoissonReconstruction& poisson,
                           const ProjectiveOptions& options = {});

/// "projective-skinning".
void register_projective_skinning(MethodTable& table);

}  // namespace ndg
