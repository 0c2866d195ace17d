// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/fit_body.h"
#include "ndg/scan/scan_truth.h"

#include <string>

namespace ndg {

/// Errors of a fit to a simulated scan, in metres, in the scan's place. Area-weighted where vertices are summed.
struct FitErrors {
    double surface_mean = 0.0;  ///< of fitted skin vertices to the true surface: the scan's noise is out of it
    double surface_p95 = 0.0, surface_max = 0.0;
    double correspondence_mean = 0.0;  ///< of skin vertices to where they truly are
    double joint_mean = 0.0;           ///< of joint centres, fingers left out
    double joint_max = 0.0;
    std::string worst_joint;
};
FitErrors measure_errors(const FittedBody& fitted, const TrueBody& truth, const Eigen::Ref<const Triangles>& triangles);

}  // namespace ndg
