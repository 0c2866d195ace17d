// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/body/template.h"
#include "ndg/core/provenance.h"
#include "ndg/dataset/gradient_file.h"

#include <string>

namespace ndg {

/// Vertices of every sample of a gradient file (NDG 4.2), in its order, with the file's method name. If `anatomy_path`
/// is not empty, the embedded anatomy of every sample goes there (anatomy_file.h): the volume as reconstructed, the
/// vertices inside the bone wrap by linear blend skinning. Throws InputError for indices out of range.
DeformationSet reconstruct_samples(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                   const GradientReader& gradients, const std::string& anatomy_path,
                                   const Provenance& provenance);

}  // namespace ndg
