// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/fit_batch.h"
#include "ndg/registration/fit_errors.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

/// What became of a batch.
class BatchReport {
public:
    /// Errors are measured for the bodies that `truth` knows.
    BatchReport(const std::vector<BatchEntry>& entries, const ScanTruth& truth,
                const Eigen::Ref<const Triangles>& triangles);

    std::size_t scans = 0, fitted = 0, passed = 0;
    std::map<std::string, FitErrors> errors;  ///< by name of the body
    /// The fitted body farthest from its truth (mean distance of the surface), or without truths from its scan; empty
    /// if there is none.
    std::string worst;
    double passed_share() const { return scans == 0 ? 0.0 : static_cast<double>(passed) / static_cast<double>(scans); }

    /// One line a scan, then the truth (means and largest values over the bodies), the count and the failures.
    std::string text(const std::vector<BatchEntry>& entries) const;
    /// JSON object: scans, fitted, passed, worst, and reports: one object a scan, with `truth_*_m` where it is known.
    std::string json(const std::vector<BatchEntry>& entries) const;
};

/// Where a reported fit's scan lies and how it is to be read.
struct ReportedFit {
    std::string name, file;
    LengthUnit unit = LengthUnit::metre;
    Axis up = Axis::y;
    double heading_degrees = 0.0;
};
/// The fit of that name, or the worst one for an empty name, from a file that json() made. Throws InputError when there
/// is none.
ReportedFit read_reported_fit(const std::string& path, const std::string& name);

}  // namespace ndg
