// SPDX-License-Identifier: Apache-2.0
// A trained network for programs without this library: TorchScript, which Python and C++ load with libtorch alone.
#pragma once

#include "ndg/neural/model.h"

#include <string>

namespace ndg {

/// The module's forward takes, in float32 on any one device,
///   parent_from_joint  B x J x 3 x 3  rotations of the pose, relative to the rest pose (the root's is not used)
///   rest_volume        B x N_v x 3    volume vertices of the bodies at rest, m
/// and gives what the model predicts for them: residual deformation gradients R_p^T F_p, B x N_p x 3 x 3, or offsets
/// of the free vertices in the rest pose, B x 2 N_w x 3, m. The extra file "metadata.json" holds the method, the
/// template's hash, the joints' names in order, options, curve, inputs and licences. Throws Error where it cannot be
/// written; the file appears whole or not at all.
void write_torchscript(const std::string& path, NeuralModel& model, const Provenance& provenance);

}  // namespace ndg
