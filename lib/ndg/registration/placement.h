// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/articulated_fit.h"
#include "ndg/registration/initial_alignment.h"

#include <string>
#include <vector>

namespace ndg {

/// A scan brought to the template, and the template's pose and proportions there.
struct Placement {
    InitialAlignment alignment;
    ScanTarget target;  ///< the scan in the template's place
    Eigen::VectorXd parameters;
    double score = 0.0;  ///< two_way_distance of the posed template, m
};

ScanTarget make_target(const ScanPoints& scan, const Eigen::Isometry3d& template_from_file);

/// Placements that may be the right one, best first, at most `count`: axes, headings and postures of the arms (as the
/// template's, hanging, sideways, raised) are aligned rigidly, the best of them posed, and those kept that fit nearly
/// as well as the best. `options`: of the fit that follows. `name` starts log lines.
std::vector<Placement> find_placements(const std::string& name, const ScanPoints& scan, const ArticulatedModel& model,
                                       const ArticulatedFitOptions& options, int count);

}  // namespace ndg
