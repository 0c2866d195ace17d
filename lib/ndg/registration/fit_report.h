// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/fit_body.h"

#include <string>

namespace ndg {

/// Fills the report's distances, coverage and triangle quality. `posed_skin` and `scan` in the same place, `rest_skin`
/// the result and `rest_template` the template with the fitted proportions, both at rest.
void measure_fit(const Eigen::Ref<const Points>& posed_skin, const Eigen::Ref<const Points>& rest_skin,
                 const Eigen::Ref<const Points>& rest_template, const Eigen::Ref<const Triangles>& triangles,
                 const ScanTarget& scan, const FitOptions& options, FitReport& report);

/// One line of figures for people, and the whole report as a JSON object.
std::string report_line(const FitReport& report);
std::string report_json(const FitReport& report);
/// The JSON object of a scan without a fit.
std::string failure_json(const std::string& file, const std::string& failure);

}  // namespace ndg
