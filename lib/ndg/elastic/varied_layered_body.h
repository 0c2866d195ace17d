// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/layered_body.h"

namespace ndg {

/// layered_body whose flesh is not the same everywhere: of every prism, muscle's, then fat's, how many times the moduli
/// of its kind it has. The skin is everywhere the same. Throws Error for another number, or one that is not positive.
ElasticBody varied_layered_body(const Template& body_template, const MaterialOptions& material,
                                const Eigen::VectorXd& stiffness_scales);

}  // namespace ndg
