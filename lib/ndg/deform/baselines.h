// SPDX-License-Identifier: Apache-2.0
// Animation without physics or network (NDG 5.2): what learned deformations are compared with.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/deform/poisson.h"
#include "ndg/deform/posed_body.h"

#include <string>
#include <vector>

namespace ndg {

/// Gradient skinning: the Poisson reconstruction of F_p = R_p, the bone wrap by linear blend skinning. N_v x 3.
/// `poisson` must hold the rest shape of `body`.
Points gradient_skinning(const BodyPoser& poser, const PoissonReconstruction& poisson, const Body& body,
                         const std::vector<Eigen::Isometry3d>& world_from_rest);

enum class Baseline { gradient_skinning, linear_blend_skinning };
/// "gradient-skinning" or "lbs"; throws InputError otherwise.
Baseline parse_baseline(const std::string& name);
/// Name in tables: "Gradient Skinning", "LBS".
std::string baseline_name(Baseline baseline);

/// Deforms every pair, in order. Throws InputError for a body or pose index out of range.
DeformationSet animate_baseline(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                const std::vector<SamplePair>& pairs, const std::string& split, Baseline baseline);

}  // namespace ndg
