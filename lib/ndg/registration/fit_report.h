// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/fit_body.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// What is measured.
struct FittedSkin {
    const Points& posed;               ///< N x 3, the result where the scan is
    const Points& rest;                ///< N x 3, the result at rest
    const Points& rest_model;          ///< N x 3, the likeliest person with the fitted proportions, at rest
    const Points& rest_joints;         ///< J x 3
    const std::vector<char>& covered;  ///< N, 1 where the scan does not show the skin
};
/// Fills the report's distances, coverage and triangle quality, its warnings and defects. `skin`: the template;
/// `floor`: height that the feet stand on in the scan's place, where it is known.
void measure_fit(const FittedSkin& fitted, const SkinnedSurface& skin, const ScanTarget& scan,
                 std::optional<double> floor, const FitOptions& options, FitReport& report);

/// One line of figures for people, and the whole report as a JSON object.
std::string report_line(const FitReport& report);
std::string report_json(const FitReport& report);
/// The JSON object of a scan without a fit.
std::string failure_json(const std::string& file, const std::string& failure);

}  // namespace ndg
