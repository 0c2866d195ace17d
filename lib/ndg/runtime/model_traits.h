// SPDX-License-Identifier: Apache-2.0
// What files of trained networks say beside the weights.
#pragma once

#include "ndg/body/posing.h"
#include "ndg/body/shape_space.h"
#include "ndg/runtime/parametrisation_kind.h"

#include <string>

namespace ndg {

/// Format "ndg-model".
inline constexpr const char* model_format = "ndg-model";
inline constexpr int model_version = 2;

/// What a network sees and what its outputs mean.
struct ModelTraits {
    std::string output_space = "residuals";
    ParametrisationKind parametrisation = ParametrisationKind::exponential;
    bool rotation = true;  ///< outputs are R_p^T F_p; otherwise F_p in the root's frame
    bool shape = true;     ///< the network sees the body
    PosingOptions posing;  ///< of the training samples
};
/// Of a file of format "ndg-model". Throws InputError naming file and attribute.
ModelTraits read_model_traits(const H5Reader& file);
/// Its shape space, of `num_coordinates` numbers a body; -1: any.
ShapeSpace read_model_shape_space(const H5Reader& file, Eigen::Index num_coordinates);
/// What codes are divided by before a network sees them, m: the standard deviation of the first component.
double shape_code_scale(const ShapeSpace& space);

}  // namespace ndg
