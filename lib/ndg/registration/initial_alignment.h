// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/articulated_fit.h"
#include "ndg/scan/scan.h"

#include <string>
#include <vector>

namespace ndg {

/// Rigid motion from the axes of a scan file (in metres) to the template's place, and the template's size.
struct InitialAlignment {
    Axis up = Axis::y;  ///< axis of the file that points up
    Eigen::Isometry3d template_from_file = Eigen::Isometry3d::Identity();
    double template_scale = 1.0;  ///< size of the person over the template's
    double error = 0.0;           ///< trimmed mean distance of scan points to the scaled template, m
};

/// Candidates for the placement of a scan, best first, at most `count`: every possible up axis and 12 headings, each
/// improved by trimmed rigid ICP of a few hundred points; floor and stature give height and size. `skin`: the template.
std::vector<InitialAlignment> align_initially(const ScanPoints& scan, const SkinnedSurface& skin, int count);

/// From landmarks alone (at least three): least-squares similarity (Umeyama 1991) of `positions` in the file's axes (m)
/// to `on_template`, both L x 3. Throws InputError, starting with `name`, when they lie on a line.
InitialAlignment align_by_landmarks(const std::string& name, const Eigen::Ref<const Points>& positions,
                                    const Eigen::Ref<const Points>& on_template);

}  // namespace ndg
