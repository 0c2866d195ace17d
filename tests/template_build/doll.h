// SPDX-License-Identifier: Apache-2.0
// A body of capsules with skeleton and weights, made without any file in a fraction of a second.
#pragma once

#include "ndg/body_source/parametric_surface.h"

namespace ndg::test {

struct Doll {
    ParametricSurface surface;
    RowMatrix weights;  ///< N x 60, dense
};
/// About 1.7 m tall, symmetric in x = 0, with a mesh of about `cell` m.
Doll make_doll(double cell = 0.02);

}  // namespace ndg::test
