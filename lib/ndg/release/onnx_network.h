// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/options.h"

#include <string>

namespace ndg {

struct OnnxOptions {
    double max_constant_mb = 500;  ///< a larger matrix is split into several constants
};
void describe(OptionList& list, OnnxOptions& options);

/// Writes a trained network (format "ndg-model") as ONNX. Inputs, float32:
///   parent_from_joint  batch x J x 3 x 3  rotations of the pose, relative to rest (the root's is not used)
///   shape_code         batch x d          code of the body's rest shape, m: components^T (volume vertices - mean);
///   absent
///                                         where the network does not see the body
/// Outputs:
///   outputs   batch x outputs       what the last layer gives: Q, nine numbers a prism, or offsets
///   residuals batch x N_p x 3 x 3   R_p^T F_p = exp(Q) (or I + Q), residual deformation gradients; of networks without
///                                   the rotation F_p in the root's frame. Absent with the parametrisations lu and qr
///   offsets   batch x 2 N_w x 3     of networks that predict vertices: of muscle wrap and skin in the rest pose, m
/// exp by eight terms of the series for Q / 64, squared six times: for |Q| <= 32 exact but for rounding.
/// Throws InputError for a damaged model, Error where nothing can be written.
void write_onnx(const std::string& path, const std::string& model_path, const OnnxOptions& options);

}  // namespace ndg
