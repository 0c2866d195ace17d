// SPDX-License-Identifier: Apache-2.0
// VertexNet (NDG section 5.2.1, after Han et al. 2024): offsets of vertices at rest, then linear blend skinning.
#pragma once

#include "ndg/neural/output_space.h"

namespace ndg {

/// RestOffsets (deform/rest_offsets.h), 2 N_w x 3, in mm; neutral: none, that is, linear blend skinning. The paper's
/// PCA decoder is the model's output basis (NetworkOptions::output_basis).
std::unique_ptr<OutputSpace> make_vertex_offsets(const Template& body_template, const NetworkOptions& options);

}  // namespace ndg
